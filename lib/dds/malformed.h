#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace gateway::dds {

/// What Cyclone DDS had to tell.
struct Malformed {
  std::uint64_t count = 0;  ///< samples and packets
  std::string newest;       ///< DDS's own words on the newest; at most 200 characters
  /// What else it told, oldest first, each at most 200 characters; at most 20 lines are kept.
  std::vector<std::string> further;
};

/// From now on counts, for the whole process, the samples and packets that Cyclone DDS drops because it
/// cannot read them (an unknown enumerator, a sequence over its bound, a struct cut short, garbage on its
/// ports). Cyclone tells of them only in its log. What else it logs is kept, too: its threads must not wait
/// for whoever reads standard error. Any thread; further calls do nothing.
void count_malformed() noexcept;

/// What was counted and kept since the last call. Any thread.
Malformed take_malformed();

}  // namespace gateway::dds
