#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "plan.h"

namespace cansyncd::campaign {

/// A drive as it is plugged in once, without power before. Times in intervals since the start.
struct Unit {
  unsigned number = 0;  ///< slave number that it is set to
  std::uint32_t type = 0;
  std::uint32_t serial = 0;
  std::uint64_t from = 0;
  std::uint64_t to = 0;    ///< unplugged
  std::uint32_t busy = 0;  ///< so many requests are answered busy first
};

/// One schedule of the course `which_drive`.
struct WhichDrivePlan {
  Plan line;  ///< seed, settings, faults, target, lateness, whether frames wake the thread
  std::vector<Unit> units;
  std::vector<std::pair<std::uint64_t, Mode>> modes;  ///< what an operator asks for, and in which interval
  unsigned control_words = 0;                         ///< that enable, in a thousand intervals
  unsigned stop_words = 0;                            ///< likewise, those that stop
  unsigned parameters = 0;                            ///< likewise, reads of clients
  std::uint64_t last = 0;                             ///< nothing is provoked after this interval
  std::uint64_t end = 0;                              ///< the course takes at least so many

  unsigned slaves() const noexcept;  ///< configured: 0..slaves()-1
  /// Has the unit what `expect` says of its number?
  bool expected(const Unit& unit) const noexcept;
};

/// A unit is plugged in no sooner than so many intervals after the one before it was unplugged.
inline constexpr std::uint64_t kShortestAbsence = 20;

/// Draws the schedule of a seed.
WhichDrivePlan draw_which_drive(std::uint64_t seed);

/// The schedule in words, one line for each thing.
std::string describe(const WhichDrivePlan& plan);

}  // namespace cansyncd::campaign
