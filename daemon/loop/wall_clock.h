#pragma once

#include <chrono>

#include "can/bus.h"
#include "can/clock_offset.h"

namespace cansyncd {

/// Translates the bus's clock into CLOCK_REALTIME. One thread; realtime safe.
class WallClock {
 public:
  /// Reads the wall clock: ns since 1970. Null: none is read, as in virtual time, and the bus's clock counts
  /// from `epoch`.
  using Read = can::Time (*)() noexcept;

  explicit WallClock(Read read, can::Time epoch = can::Time{0}) noexcept : read_(read), offset_(epoch) {}

  /// Measures the offset between both clocks again. A thread that is held up while it reads them knows it no
  /// better than that takes: it tries again, and keeps the former offset as long as that may be right.
  void adjust(can::Bus& bus) noexcept {
    if (read_ == nullptr) return;
    const can::ClockOffset read = can::read_clock_offset([&bus] { return bus.now(); }, read_, kUndisturbed);
    const can::Time change = read.ahead - offset_;
    if (change <= read.doubt && change >= -read.doubt) return;
    offset_ = read.ahead;
  }

  /// Wall clock at an instant of the bus's clock.
  can::Time at(can::Time bus_time) const noexcept { return bus_time + offset_; }

 private:
  static constexpr can::Time kUndisturbed = std::chrono::microseconds(2);

  Read read_;
  can::Time offset_;
};

/// CLOCK_REALTIME now.
can::Time read_realtime_clock() noexcept;

}  // namespace cansyncd
