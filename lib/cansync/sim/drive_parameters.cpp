#include "cansync/sim/drive_parameters.h"

#include <limits>

namespace sim {
namespace {

using cansync::ParameterAnswer;
using cansync::ParameterError;
using Access = ParameterDefinition::Access;

constexpr std::int64_t kLargest = std::numeric_limits<std::int32_t>::max();

constexpr ParameterDefinition read_only(std::uint16_t number, bool doubleword, std::uint32_t initial = 0) {
  return {number, doubleword, Access::read_only, initial, 0, 0, false, false};
}

constexpr ParameterDefinition limited(std::uint16_t number, bool doubleword, std::uint32_t initial,
                                      std::int64_t minimum, std::int64_t maximum) {
  return {number, doubleword, Access::read_write, initial, minimum, maximum, true, false};
}

constexpr ParameterDefinition plain(std::uint16_t number, bool doubleword) {
  return {number, doubleword, Access::read_write, 0, 0, 0, false, false};
}

constexpr ParameterDefinition kStandard[] = {
    read_only(parameter::device_type, false, 4400),
    read_only(parameter::firmware_version, true, 0x00010000),
    read_only(parameter::serial_number, true),
    read_only(parameter::slave_number, false),
    read_only(parameter::control_word, false),
    read_only(parameter::status_word, false),
    limited(parameter::operating_mode, false, 0, 0, 1),
    read_only(parameter::fault_code, false),
    read_only(parameter::missed_references, true),
    read_only(parameter::misses_in_a_row, false),
    read_only(parameter::missed_edges, true),
    read_only(parameter::position, true),
    read_only(parameter::speed, true),
    read_only(parameter::torque, false),
    read_only(parameter::following_error, true),
    read_only(parameter::temperature, false),
    read_only(parameter::position_setpoint, true),
    read_only(parameter::last_action, true),
    read_only(parameter::action_count, true),
    limited(parameter::lag, false, 50, 0, 10'000),
    limited(parameter::maximum_speed, true, 100'000'000, 1, kLargest),
    limited(parameter::deceleration, true, 10'000'000, 1, kLargest),
    limited(parameter::torque_offset, false, 0, -1000, 1000),
    {parameter::busy, false, Access::read_write, 410, 0, 0, false, false},
    {parameter::busy_replies, false, Access::read_write, 3, 0, 0, false, false},
    {parameter::not_available, false, Access::not_available, 0, 0, 0, false, false},
    plain(parameter::user_doubleword, true),
};

}  // namespace

std::vector<ParameterDefinition> standard_parameters() {
  std::vector<ParameterDefinition> definitions(std::begin(kStandard), std::end(kStandard));
  for (std::uint16_t i = 0; i < parameter::plain_count; ++i) {
    definitions.push_back(plain(static_cast<std::uint16_t>(parameter::first_plain_word + i), false));
    definitions.push_back(plain(static_cast<std::uint16_t>(parameter::first_plain_doubleword + i), true));
  }
  return definitions;
}

void DriveParameters::reset() noexcept {
  table_.reset();
  busy_given_ = 0;
}

bool DriveParameters::still_busy(cansync::ParameterNumber number) noexcept {
  if (number.value() != parameter::busy) return false;
  if (busy_replies_ != kEndless && busy_given_ >= busy_replies_) {
    busy_given_ = 0;
    return false;
  }
  ++busy_given_;
  return true;
}

ParameterAnswer DriveParameters::read(cansync::ParameterNumber number, cansync::Element element) noexcept {
  ParameterAnswer answer = table_.read(number, element);
  if (answer.error == ParameterError::none) answer.busy = still_busy(number);
  return answer;
}

ParameterAnswer DriveParameters::write(cansync::ParameterNumber number, bool doubleword,
                                       std::uint32_t value) noexcept {
  ParameterAnswer answer = table_.check(number, doubleword, value);
  if (answer.error != ParameterError::none) return answer;
  answer.busy = still_busy(number);
  if (!answer.busy) table_.set_value(number.value(), value);
  return answer;
}

}  // namespace sim
