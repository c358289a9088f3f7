#include <chrono>

#include "cansync/sim/drive.h"

// What a master's parameter and transfer jobs find behind the drive.
namespace sim {

using cansync::ParameterAnswer;
using cansync::ParameterError;

namespace {

/// This value of the parameter `busy_replies` means: for ever.
constexpr std::uint32_t kEndlesslyBusy = 0xFFFF;

}  // namespace

bool Drive::busy_by_order() noexcept {
  if (busy_requests_ == 0) return false;
  if (busy_requests_ != DriveParameters::kEndless) --busy_requests_;
  return true;
}

ParameterAnswer Drive::read_parameter(cansync::ParameterNumber number, cansync::Element element,
                                      cansync::SubSlave sub) noexcept {
  if (sub.value != 0) return ParameterAnswer::refused(ParameterError::not_present);
  if (busy_by_order()) return ParameterAnswer::later();
  if (const std::optional<std::uint32_t> value = live_value(number.value())) {
    parameters_.set_value(number.value(), *value);
  }
  return parameters_.read(number, element);
}

ParameterAnswer Drive::write_parameter(cansync::ParameterNumber number, cansync::Element /*element*/,
                                       cansync::SubSlave sub, bool doubleword, std::uint32_t value) noexcept {
  if (sub.value != 0) return ParameterAnswer::refused(ParameterError::not_present);
  if (busy_by_order()) return ParameterAnswer::later();
  const ParameterAnswer answer = parameters_.write(number, doubleword, value);
  if (answer.busy || answer.error != ParameterError::none) return answer;
  apply_parameters();
  if (watcher_ != nullptr) watcher_->parameter_written(this->number(), number, value);
  return answer;
}

bool Drive::set_parameter(std::uint16_t number, std::uint32_t value) noexcept {
  if (!parameters_.set_value(number, value)) return false;
  apply_parameters();
  return true;
}

std::optional<std::uint32_t> Drive::live_value(std::uint16_t number) const noexcept {
  if (number == settings_.status_parameter) return status_word();
  switch (number) {
    case parameter::control_word:
      return control_word_;
    case parameter::status_word:
      return status_word();
    case parameter::fault_code:
      return fault_;
    case parameter::missed_references:
      return supervision_.missed_references();
    case parameter::misses_in_a_row:
      return supervision_.misses();
    case parameter::missed_edges:
      return supervision_.missed_edges();
    case parameter::position:
      return actual_[0];
    case parameter::speed:
      return actual_[1];
    case parameter::following_error:
      return actual_[2];
    case parameter::position_setpoint:
      return actual_[3];
    case parameter::torque:
      return actual_[4];
    case parameter::temperature:
      return actual_[6];
    case parameter::last_action:
      return last_action_;
    case parameter::action_count:
      return action_count_;
    default:
      return std::nullopt;
  }
}

void Drive::apply_parameters() noexcept {
  const auto number = [this](std::uint16_t parameter, std::uint32_t otherwise) {
    return parameters_.value(parameter).value_or(otherwise);
  };
  motion_.set_lag(std::chrono::microseconds(100) * number(parameter::lag, 50));
  motion_.set_maximum_speed(number(parameter::maximum_speed, 100'000'000));
  motion_.set_deceleration(number(parameter::deceleration, 10'000'000));
  motion_.set_torque_offset(static_cast<std::int16_t>(number(parameter::torque_offset, 0)));
  const std::uint32_t busy_replies = number(parameter::busy_replies, 0);
  parameters_.set_busy_replies(busy_replies == kEndlesslyBusy ? DriveParameters::kEndless : busy_replies);
  const bool speed_mode = number(parameter::operating_mode, 0) == 1;
  if (speed_mode != speed_mode_) {
    speed_mode_ = speed_mode;
    choose_reference();
  }
}

Drive::BlockAnswer Drive::begin_block(const cansync::TransferInitialise& initialise) noexcept {
  return memory_.begin(initialise);
}

Drive::BlockAnswer Drive::read_block(std::uint16_t offset, std::span<std::uint8_t> out) noexcept {
  return memory_.read(offset, out);
}

Drive::BlockAnswer Drive::write_block(std::uint16_t offset, std::span<const std::uint8_t> data) noexcept {
  return memory_.write(offset, data);
}

}  // namespace sim
