#pragma once

#include <cstdint>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// Whether the reference values of one telegram are released, and if not, why.
struct ReleaseStatus {
  /// What becomes of the telegram in this interval.
  enum class State : std::uint8_t {
    stopped,   ///< the telegram is left out
    released,  ///< as the values' giver wants it
    held,      ///< released a little longer although the giver is lost or silent
  };
  /// Why it is held or stopped: what its giver has to mend.
  enum class Cause : std::uint8_t {
    none,             ///< released, or nothing was given since active operation began
    used_up,          ///< released as often as the update said
    too_old,          ///< no newer values within `ProcessSettings::too_old_after`
    withdrawn,        ///< by `Master::stop_release`, or another giver took over whose values were refused
    mapping_changed,  ///< given for another reference mapping than the one in force
    bus_lost,         ///< given before the bus was gone
  };
  State state = State::stopped;
  Cause cause = Cause::none;  ///< of being held or stopped
  IntervalNumber given = 0;   ///< interval in which the newest values were taken into use
  std::uint64_t updates = 0;  ///< taken into use since the start
  std::uint64_t too_old = 0;  ///< times since the start that values grew too old
  std::uint64_t mapping_changed =
      0;  ///< times since the start that a change of the mapping ended the release
  std::uint64_t beyond_limits =
      0;  ///< updates since the start that were refused for a limit (`ReferenceCheck`)
};

}  // namespace cansync
