#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sync/phase_lock.h"

namespace sync_line {

/// One reading of a hardware clock beside CLOCK_MONOTONIC.
struct ClockSample {
  Time monotonic{0};
  Time hardware{0};
  Time uncertainty{0};  ///< width of the window in which the hardware clock was read
};

/// A straight line between two clocks.
struct ClockLine {
  Time monotonic{0};  ///< one instant on both clocks
  Time hardware{0};
  double rate = 1;  ///< hardware seconds per monotonic second

  /// The instant on CLOCK_MONOTONIC at which the hardware clock shows `hardware_time`.
  Time to_monotonic(Time hardware_time) const noexcept;
  /// What the hardware clock shows at an instant of CLOCK_MONOTONIC.
  Time to_hardware(Time monotonic_time) const noexcept;
};

/// Offset and frequency between a hardware clock and CLOCK_MONOTONIC: a straight line through the last 16
/// readings, by least squares. Readings four times as uncertain as the best one kept are left out. Three
/// readings in a row that the line does not explain mean that the clock was set; then it starts anew.
///
/// Pure: no clock, no system call, no allocation. One thread.
class ClockRelation {
 public:
  /// Takes a reading. Readings must come in the order of `monotonic`.
  void add(const ClockSample& sample) noexcept;

  /// True when enough readings (4) lie behind `line`.
  bool valid() const noexcept { return count_ >= kLeast; }

  /// The relation, anchored at the newest reading that was used.
  const ClockLine& line() const noexcept { return line_; }

  /// How often the hardware clock was set since the start.
  std::uint64_t steps() const noexcept { return steps_; }

 private:
  static constexpr std::size_t kKept = 16;
  static constexpr std::size_t kLeast = 4;

  bool too_uncertain(const ClockSample& sample) const noexcept;
  void keep(const ClockSample& sample) noexcept;
  void fit() noexcept;

  std::array<ClockSample, kKept> samples_ = {};  ///< oldest first
  std::size_t count_ = 0;
  ClockLine line_;
  unsigned unexplained_ = 0;
  unsigned uncertain_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace sync_line
