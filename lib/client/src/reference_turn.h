#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace cansync::client {

/// Reference values of one telegram that are repeated; `valid` 0: none.
struct RepeatedTelegram {
  std::array<std::int32_t, 4> value = {};
  std::uint8_t valid = 0;
};

/// Gives `write(telegram 1 or 2, values)` each telegram that has values, also when the one before failed.
/// `write` returns why it failed, empty when it did not; returned is what failed first.
template <class Write>
std::string write_turn(const std::array<RepeatedTelegram, 2>& telegrams, Write&& write) {
  std::string failed;
  for (std::size_t i = 0; i < telegrams.size(); ++i) {
    if (telegrams[i].valid == 0) continue;
    std::string problem = write(static_cast<std::uint8_t>(i + 1), telegrams[i]);
    if (failed.empty()) failed = std::move(problem);
  }
  return failed;
}

}  // namespace cansync::client
