#pragma once

#include <cstdint>
#include <string>

#include "cansync/observe/learned.h"

namespace cansync::cli {

/// What a configuration is made for.
struct LearnedPlace {
  std::string source;     ///< the recording, for a comment
  std::string bus;        ///< bus.name
  std::string interface;  ///< bus.interface
  /// Slaves that get a profile of their own, "learned-N".
  std::uint32_t profiles = 0;
};

/// A configuration of cansyncd that does what the recorded master did. Each option has a comment that says
/// how it is known; those the recording tells nothing of stand as comments with their default. Pure.
std::string learned_configuration(const observe::Observation& observation, const observe::Learned& learned,
                                  const LearnedPlace& place);

/// Name of the profile of a slave that was learned: "learned-3".
std::string learned_profile_name(unsigned slave);

}  // namespace cansync::cli
