#include "cansync/sim/drive_parameters.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sim {
namespace {

using cansync::ParameterAnswer;
using cansync::ParameterError;
using Access = ParameterDefinition::Access;

constexpr std::uint8_t kMinimumElement = 0;
constexpr std::uint8_t kMaximumElement = 1;
constexpr std::uint8_t kInitialElement = 2;

constexpr std::int64_t kLargest = std::numeric_limits<std::int32_t>::max();

std::uint32_t fit(const ParameterDefinition& definition, std::uint32_t value) noexcept {
  return definition.doubleword ? value : value & 0xFFFF;
}

/// The raw value as a number: signed when the parameter has a minimum below zero.
std::int64_t as_number(const ParameterDefinition& definition, std::uint32_t value) noexcept {
  if (definition.minimum >= 0) return value;
  return definition.doubleword ? static_cast<std::int32_t>(value) : static_cast<std::int16_t>(value);
}

ParameterAnswer failed(ParameterError error) noexcept {
  ParameterAnswer answer;
  answer.error = error;
  return answer;
}

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
    {parameter::busy, false, Access::read_write, 410, 0, 0, false, true},
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

DriveParameters::DriveParameters(const std::vector<ParameterDefinition>& definitions) {
  for (const ParameterDefinition& definition : definitions) {
    if (definition.number > cansync::ParameterNumber::max) continue;
    if (Entry* entry = find(definition.number)) {
      entry->definition = definition;
      continue;
    }
    const auto place =
        std::lower_bound(entries_.begin(), entries_.end(), definition.number,
                         [](const Entry& entry, std::uint16_t n) { return entry.definition.number < n; });
    entries_.insert(place, Entry{definition, 0});
  }
  reset();
}

void DriveParameters::reset() noexcept {
  for (Entry& entry : entries_) entry.value = fit(entry.definition, entry.definition.initial);
  busy_given_ = 0;
}

const DriveParameters::Entry* DriveParameters::find(std::uint16_t number) const noexcept {
  const auto place =
      std::lower_bound(entries_.begin(), entries_.end(), number,
                       [](const Entry& entry, std::uint16_t n) { return entry.definition.number < n; });
  return place != entries_.end() && place->definition.number == number ? &*place : nullptr;
}

DriveParameters::Entry* DriveParameters::find(std::uint16_t number) noexcept {
  return const_cast<Entry*>(std::as_const(*this).find(number));
}

bool DriveParameters::still_busy(const Entry& entry) noexcept {
  if (!entry.definition.answers_busy_first) return false;
  if (busy_replies_ != kEndless && busy_given_ >= busy_replies_) {
    busy_given_ = 0;
    return false;
  }
  ++busy_given_;
  return true;
}

ParameterAnswer DriveParameters::read(cansync::ParameterNumber number, cansync::Element element) noexcept {
  const Entry* entry = find(number.value());
  if (entry == nullptr) return failed(ParameterError::not_present);
  const ParameterDefinition& definition = entry->definition;
  if (definition.access == Access::not_available) return failed(ParameterError::not_available_now);
  ParameterAnswer answer;
  answer.doubleword = definition.doubleword;
  if (element == cansync::kValueElement) {
    answer.value = entry->value;
  } else if (element.value() == kInitialElement) {
    answer.value = fit(definition, definition.initial);
  } else if (definition.limited && element.value() == kMinimumElement) {
    answer.value = fit(definition, static_cast<std::uint32_t>(definition.minimum));
  } else if (definition.limited && element.value() == kMaximumElement) {
    answer.value = fit(definition, static_cast<std::uint32_t>(definition.maximum));
  } else {
    return failed(ParameterError::not_present);
  }
  answer.busy = still_busy(*entry);
  return answer;
}

ParameterAnswer DriveParameters::write(cansync::ParameterNumber number, bool doubleword,
                                       std::uint32_t value) noexcept {
  Entry* entry = find(number.value());
  if (entry == nullptr) return failed(ParameterError::not_present);
  const ParameterDefinition& definition = entry->definition;
  if (definition.access == Access::not_available) return failed(ParameterError::not_available_now);
  if (definition.access == Access::read_only) return failed(ParameterError::not_changeable);
  if (definition.doubleword != doubleword) return failed(ParameterError::wrong_format);
  if (definition.limited) {
    const std::int64_t wanted = as_number(definition, value);
    if (wanted < definition.minimum) return failed(ParameterError::below_minimum);
    if (wanted > definition.maximum) return failed(ParameterError::above_maximum);
  }
  ParameterAnswer answer;
  answer.doubleword = doubleword;
  answer.busy = still_busy(*entry);
  if (!answer.busy) entry->value = fit(definition, value);
  return answer;
}

std::optional<std::uint32_t> DriveParameters::value(std::uint16_t number) const noexcept {
  const Entry* entry = find(number);
  if (entry == nullptr) return std::nullopt;
  return entry->value;
}

bool DriveParameters::set_value(std::uint16_t number, std::uint32_t value) noexcept {
  Entry* entry = find(number);
  if (entry == nullptr) return false;
  entry->value = fit(entry->definition, value);
  return true;
}

}  // namespace sim
