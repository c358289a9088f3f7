#pragma once

#include <chrono>

#include "can/bus.h"

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
    can::Time measured{};
    can::Time doubt = can::Time::max();
    for (unsigned i = 0; i < kTries && doubt > kUndisturbed; ++i) {
      const can::Time before = bus.now();
      const can::Time wall = read_();
      const can::Time half = (bus.now() - before) / 2;
      if (half >= doubt) continue;
      doubt = half;
      measured = wall - (before + half);
    }
    const can::Time change = measured - offset_;
    if (change <= doubt && change >= -doubt) return;
    offset_ = measured;
  }

  /// Wall clock at an instant of the bus's clock.
  can::Time at(can::Time bus_time) const noexcept { return bus_time + offset_; }

 private:
  static constexpr unsigned kTries = 3;
  static constexpr can::Time kUndisturbed = std::chrono::microseconds(2);

  Read read_;
  can::Time offset_;
};

/// CLOCK_REALTIME now.
can::Time read_realtime_clock() noexcept;

}  // namespace cansyncd
