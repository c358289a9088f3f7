#pragma once

#include <cstdint>

#include "cansync/telegram/numbers.h"

namespace sim {

/// A reference value followed over the intervals: unwraps it, and carries it on with its last speed while it
/// is missing (O 7.2). Nothing allocates, blocks or throws.
class ReferenceTracker {
 public:
  /// `word`: the value has 16 bits and wraps there; else 32.
  explicit ReferenceTracker(bool word = false) noexcept : word_(word) {}

  /// The reference value came in this interval.
  void take(std::uint32_t raw) noexcept;

  /// None came in this interval.
  void miss() noexcept {
    ++misses_;
    value_ += step_;
  }

  /// Until the next reference value there is none; where the value stood is kept.
  void forget() noexcept {
    seen_ = false;
    step_ = 0;
    misses_ = 0;
  }

  bool seen() const noexcept { return seen_; }
  /// Intervals in a row without a reference value.
  std::uint32_t misses() const noexcept { return misses_; }
  /// The value, in its own units, beyond 16 or 32 bits where it has wrapped.
  double value() const noexcept { return value_; }

 private:
  double value_ = 0;
  double step_ = 0;  ///< per interval
  std::int64_t exact_ = 0;
  std::uint32_t raw_ = 0;
  std::uint32_t misses_ = 0;
  bool word_;
  bool seen_ = false;
};

/// What moves the axis in one interval.
enum class MotionMode : std::uint8_t {
  coast,      ///< no power: friction alone
  ramp_down,  ///< powered, to a standstill with the deceleration
  position,   ///< follows a position with a first-order lag
  speed,      ///< follows a speed with a first-order lag
};

/// The axis: position in increments, speed in increments/s, torque in 0.1 % of the nominal torque. Nothing
/// allocates, blocks or throws; the same steps give the same bits.
class DriveMotion {
 public:
  /// `interval` is the time of one step.
  explicit DriveMotion(cansync::Duration interval) noexcept;

  /// Time constant of the lag behind the reference value; 0 = none.
  void set_lag(cansync::Duration lag) noexcept;
  /// Increments/s, over 0.
  void set_maximum_speed(double speed) noexcept { maximum_speed_ = speed; }
  /// Increments/s^2, over 0.
  void set_deceleration(double deceleration) noexcept { speed_step_ = deceleration * seconds_; }
  /// 0.1 % of the nominal torque, added while powered.
  void set_torque_offset(double offset) noexcept { torque_offset_ = offset; }

  /// One interval; `target` is a position or a speed, or not looked at.
  void step(MotionMode mode, double target) noexcept;

  /// Takes whole turns of 2^32 increments off the position, so that it stands within 32 bits, signed.
  void rebase() noexcept;

  double position() const noexcept { return position_; }
  double speed() const noexcept { return speed_; }
  double torque() const noexcept { return torque_; }
  /// 0.1 degree Celsius: rises with the square of the torque.
  double temperature() const noexcept { return temperature_; }

 private:
  double next_speed(MotionMode mode, double target) const noexcept;

  double seconds_;
  double per_second_;
  double gain_ = 1;
  double maximum_speed_ = 1e8;
  double speed_step_ = 0;
  double torque_offset_ = 0;
  double coast_factor_;
  double warming_;
  double position_ = 0;
  double speed_ = 0;
  double torque_ = 0;
  double temperature_;
};

}  // namespace sim
