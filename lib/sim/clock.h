#pragma once

#include <cstdint>

#include "can/bus.h"

namespace sim {

/// Which time a simulated line lives in.
enum class ClockKind : std::uint8_t {
  virtual_time,  ///< starts at 0 and jumps to whatever is waited for: deterministic, no system calls
  real_time,     ///< CLOCK_MONOTONIC, with absolute sleeps
};

/// The clock of a simulated line. Realtime safe; not thread safe.
class LineClock {
 public:
  explicit LineClock(ClockKind kind) noexcept : kind_(kind) {}

  ClockKind kind() const noexcept { return kind_; }

  /// The clock now: virtual, where it was last moved to; real, nanoseconds of CLOCK_MONOTONIC.
  can::Time now() const noexcept;

  /// Sleeps until `instant`; returns at once when it has passed. False: a signal came first (real time only).
  bool sleep_until(can::Time instant) noexcept;

 private:
  ClockKind kind_;
  can::Time virtual_now_{};
};

}  // namespace sim
