#pragma once

#include <cstdint>
#include <cstring>

namespace gateway::dds {

/// The number that lies where an enumerator of the data model should be. DDS drops samples with unknown ones,
/// but who checks a sample must not count on that: to read a number that is no enumerator as one is
/// undefined.
template <class Enumeration>
std::int64_t raw_number_of(const Enumeration& enumerator) noexcept {
  std::uint32_t number = 0;
  static_assert(sizeof enumerator == sizeof number);
  std::memcpy(&number, &enumerator, sizeof number);
  return number;
}

}  // namespace gateway::dds
