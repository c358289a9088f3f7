#include "cansync/sim/drive_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sim {
namespace {

// A plausible axis: nominal torque gives 10^7 increments/s^2, friction takes 10 % at 10^6 increments/s.
constexpr double kTorquePerAcceleration = 1000.0 / 1e7;
constexpr double kTorquePerSpeed = 100.0 / 1e6;
constexpr double kStaticFriction = 20.0;
constexpr double kMaximumTorque = 3000.0;
constexpr double kStandstill = 0.5;     // increments/s
constexpr double kSnap = 1e-6;          // what is closer counts as there, so that nothing decays for ever
constexpr double kCoastTime = 0.5;      // s, time constant of an axis without power
constexpr double kWarmingTime = 120.0;  // s
constexpr double kTurn = 4294967296.0;  // increments, 2^32
constexpr double kAmbient = 250.0;      // 0.1 degree Celsius
constexpr double kHeating = 500.0;      // 0.1 degree Celsius at nominal torque

double gain_for(double seconds, double time_constant) noexcept {
  return time_constant <= 0 ? 1.0 : 1.0 - std::exp(-seconds / time_constant);
}

}  // namespace

void ReferenceTracker::take(std::uint32_t raw) noexcept {
  const std::uint32_t distance = raw - raw_;
  const std::int64_t delta =
      word_ ? std::int64_t{static_cast<std::int16_t>(distance)} : static_cast<std::int32_t>(distance);
  exact_ += delta;
  raw_ = raw;
  // Without a value just before there is no speed to carry on with.
  if (seen_) {
    step_ = static_cast<double>(delta);
    if (misses_ != 0) step_ /= misses_ + 1.0;
  } else {
    step_ = 0;
  }
  value_ = static_cast<double>(exact_);
  misses_ = 0;
  seen_ = true;
}

DriveMotion::DriveMotion(cansync::Duration interval) noexcept
    : seconds_(std::chrono::duration<double>(interval).count()),
      per_second_(1.0 / seconds_),
      coast_factor_(1.0 - gain_for(seconds_, kCoastTime)),
      warming_(gain_for(seconds_, kWarmingTime)),
      temperature_(kAmbient) {}

void DriveMotion::set_lag(cansync::Duration lag) noexcept {
  gain_ = gain_for(seconds_, std::chrono::duration<double>(lag).count());
}

void DriveMotion::rebase() noexcept {
  position_ -= std::round(position_ / kTurn) * kTurn;
}

double DriveMotion::next_speed(MotionMode mode, double target) const noexcept {
  switch (mode) {
    case MotionMode::coast: {
      const double speed = speed_ * coast_factor_;
      return std::abs(speed) < kSnap ? 0 : speed;
    }
    case MotionMode::ramp_down:
      return speed_ - std::clamp(speed_, -speed_step_, speed_step_);
    case MotionMode::position: {
      const double error = target - position_;
      const double move = std::abs(error) < kSnap ? error : error * gain_;
      return std::clamp(move * per_second_, -maximum_speed_, maximum_speed_);
    }
    case MotionMode::speed: {
      const double error = std::clamp(target, -maximum_speed_, maximum_speed_) - speed_;
      return std::abs(error) < kSnap ? speed_ + error : speed_ + error * gain_;
    }
  }
  return 0;
}

void DriveMotion::step(MotionMode mode, double target) noexcept {
  const double speed = next_speed(mode, target);
  const double acceleration = (speed - speed_) * per_second_;
  speed_ = speed;
  position_ += speed * seconds_;
  torque_ = 0;
  if (mode != MotionMode::coast) {
    const double friction =
        speed > kStandstill ? kStaticFriction : (speed < -kStandstill ? -kStaticFriction : 0);
    torque_ = std::clamp(
        acceleration * kTorquePerAcceleration + speed * kTorquePerSpeed + friction + torque_offset_,
        -kMaximumTorque, kMaximumTorque);
  }
  const double load = torque_ * 1e-3;
  temperature_ += (kAmbient + kHeating * load * load - temperature_) * warming_;
}

}  // namespace sim
