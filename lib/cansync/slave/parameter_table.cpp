#include "cansync/slave/parameter_table.h"

#include <algorithm>
#include <utility>

namespace cansync {
namespace {

using Access = ParameterDefinition::Access;

constexpr std::uint8_t kMinimumElement = 0;
constexpr std::uint8_t kMaximumElement = 1;
constexpr std::uint8_t kInitialElement = 2;

std::uint32_t fit(const ParameterDefinition& definition, std::uint32_t value) noexcept {
  return definition.doubleword ? value : value & 0xFFFF;
}

/// The raw value as a number: signed when the parameter has a minimum below zero.
std::int64_t as_number(const ParameterDefinition& definition, std::uint32_t value) noexcept {
  return cansync::number_of(value, !definition.doubleword, definition.minimum < 0);
}

ParameterAnswer failed(ParameterError error) noexcept {
  ParameterAnswer answer;
  answer.error = error;
  return answer;
}

}  // namespace

ParameterTable::ParameterTable(const std::vector<ParameterDefinition>& definitions) {
  for (const ParameterDefinition& definition : definitions) {
    if (definition.number > ParameterNumber::max) continue;
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

void ParameterTable::reset() noexcept {
  for (Entry& entry : entries_) entry.value = fit(entry.definition, entry.definition.initial);
}

const ParameterTable::Entry* ParameterTable::find(std::uint16_t number) const noexcept {
  const auto place =
      std::lower_bound(entries_.begin(), entries_.end(), number,
                       [](const Entry& entry, std::uint16_t n) { return entry.definition.number < n; });
  return place != entries_.end() && place->definition.number == number ? &*place : nullptr;
}

ParameterTable::Entry* ParameterTable::find(std::uint16_t number) noexcept {
  return const_cast<Entry*>(std::as_const(*this).find(number));
}

const ParameterDefinition* ParameterTable::definition(std::uint16_t number) const noexcept {
  const Entry* entry = find(number);
  return entry == nullptr ? nullptr : &entry->definition;
}

ParameterAnswer ParameterTable::read(ParameterNumber number, Element element) const noexcept {
  const Entry* entry = find(number.value());
  if (entry == nullptr) return failed(ParameterError::not_present);
  const ParameterDefinition& definition = entry->definition;
  if (definition.access == Access::not_available) return failed(ParameterError::not_available_now);
  ParameterAnswer answer;
  answer.doubleword = definition.doubleword;
  if (element == kValueElement) {
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
  return answer;
}

ParameterAnswer ParameterTable::check(ParameterNumber number, bool doubleword,
                                      std::uint32_t value) const noexcept {
  const ParameterDefinition* definition = this->definition(number.value());
  if (definition == nullptr) return failed(ParameterError::not_present);
  if (definition->access == Access::not_available) return failed(ParameterError::not_available_now);
  if (definition->access == Access::read_only) return failed(ParameterError::not_changeable);
  if (definition->doubleword != doubleword) return failed(ParameterError::wrong_format);
  if (definition->limited) {
    const std::int64_t wanted = as_number(*definition, value);
    if (wanted < definition->minimum) return failed(ParameterError::below_minimum);
    if (wanted > definition->maximum) return failed(ParameterError::above_maximum);
  }
  ParameterAnswer answer;
  answer.doubleword = doubleword;
  return answer;
}

ParameterAnswer ParameterTable::write(ParameterNumber number, bool doubleword, std::uint32_t value) noexcept {
  const ParameterAnswer answer = check(number, doubleword, value);
  if (answer.error == ParameterError::none) set_value(number.value(), value);
  return answer;
}

std::optional<std::uint32_t> ParameterTable::value(std::uint16_t number) const noexcept {
  const Entry* entry = find(number);
  if (entry == nullptr) return std::nullopt;
  return entry->value;
}

bool ParameterTable::set_value(std::uint16_t number, std::uint32_t value) noexcept {
  Entry* entry = find(number);
  if (entry == nullptr) return false;
  entry->value = fit(entry->definition, value);
  return true;
}

}  // namespace cansync
