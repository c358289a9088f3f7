#pragma once

#include <cstdint>
#include <string>

namespace cansync::dds {

/// What DDS received but could not read.
struct Malformed {
  std::uint64_t count = 0;  ///< samples and packets
  std::string newest;       ///< DDS's own words on the newest; at most 200 characters
};

/// From now on counts, for the whole process, the samples and packets that Cyclone DDS drops because it
/// cannot read them (an unknown enumerator, a sequence over its bound, a struct cut short, garbage on its
/// ports). Cyclone tells of them only in its log, so they are taken out of it; everything else that it logs
/// goes to standard error as before, at most 20 lines a second. Any thread; further calls do nothing.
void count_malformed() noexcept;

/// What was counted since the last call. Any thread.
Malformed take_malformed();

}  // namespace cansync::dds
