#pragma once

#include "can/bus.h"

namespace cansyncd {

/// Translates the bus's clock into CLOCK_REALTIME. One thread; realtime safe.
class WallClock {
 public:
  /// Reads the wall clock: ns since 1970. Null: none is read, as in virtual time, and the bus's clock counts
  /// from `epoch`.
  using Read = can::Time (*)() noexcept;

  explicit WallClock(Read read, can::Time epoch = can::Time{0}) noexcept : read_(read), offset_(epoch) {}

  /// Measures the offset between both clocks again.
  void adjust(can::Bus& bus) noexcept {
    if (read_ == nullptr) return;
    const can::Time before = bus.now();
    const can::Time wall = read_();
    const can::Time after = bus.now();
    offset_ = wall - (before + (after - before) / 2);
  }

  /// Wall clock at an instant of the bus's clock.
  can::Time at(can::Time bus_time) const noexcept { return bus_time + offset_; }

 private:
  Read read_;
  can::Time offset_;
};

/// CLOCK_REALTIME now.
can::Time read_realtime_clock() noexcept;

}  // namespace cansyncd
