#pragma once

#include <cstdint>

#include "can/bus.h"
#include "daemon/bus/bus_load.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/loop/wall_clock.h"

namespace cansyncd {

/// What the machine of a protocol without intervals does in each turn of its loop whatever the protocol:
/// looks at the controller and tells the flight recorder of it, and measures the load of the bus and the time
/// of day. Realtime thread only; realtime safe.
class ControllerWatch {
 public:
  /// What has happened since the turn before.
  struct News {
    bool emptied = false;      ///< what was handed over is gone
    bool echoes_lost = false;  ///< the kernel dropped frames, which may have been echoes
    bool changed = false;      ///< state, link or delivery: worth telling at once
  };

  /// `bits_per_second`: over 0. `tap`: the flight recorder; null: none. `bus` must outlive the watch.
  ControllerWatch(can::Bus& bus, std::uint32_t bits_per_second, WallClock::Read read, FlightTap* tap) noexcept
      : bus_(bus), clock_(read), load_(bits_per_second), tap_(tap) {}

  /// Before the first turn.
  void begin(can::Time now) noexcept;
  /// At the beginning of each turn.
  News turn(can::Time now) noexcept;
  /// A frame was on the bus.
  void add(const can::Frame& frame) noexcept { load_.add(frame); }

  const can::ControllerStatus& controller() const noexcept { return controller_; }
  /// Share of the last second in which the bus was busy, in permille.
  std::uint32_t bus_load() const noexcept { return last_load_; }
  /// Wall clock at an instant of the bus's clock.
  can::Time wall_clock(can::Time at) const noexcept { return clock_.at(at); }

 private:
  void record(const can::ControllerStatus& before, const Moment& moment) noexcept;

  can::Bus& bus_;
  WallClock clock_;
  BusLoad load_;
  FlightTap* const tap_;
  can::ControllerStatus controller_;
  std::uint32_t last_load_ = 0;
  can::Time next_second_{};
  std::uint64_t turns_ = 0;
};

}  // namespace cansyncd
