#pragma once

#include <cstddef>

#include "config/document.h"
#include "require.h"

/// What a reader allocates, held against the size of what it reads.
namespace fuzz {

/// Since the start of the program, freed or not; 0 without the address sanitizer.
extern std::size_t allocated;

/// TOML text as nodes, and what is made of them.
inline constexpr std::size_t kOfText = 150;
/// TOML of which damaged sections are left out one by one, with up to three looks for each.
inline constexpr std::size_t kOfTextInPart = kOfText * 3 * config::kMostDamagedSections;

/// Does `read`, which must allocate no more in all than so many times the input's size, beside a fixed part: what a
/// file names must not decide how much memory, and work, it takes.
template <class Read>
auto bounded(std::size_t size, std::size_t times, const Read& read) {
  constexpr std::size_t kFixed = std::size_t{512} << 10;  // tables of options, words of errors
  const std::size_t before = allocated;
  auto out = read();
  require(allocated - before <= kFixed + times * size, "what is allocated is bounded by the input's size");
  return out;
}

}  // namespace fuzz
