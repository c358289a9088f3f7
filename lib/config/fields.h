#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "config/rows.h"

/// Rows whose value is one field of the draft. The field's own initial value is the option's default: it
/// stands nowhere else. Main thread only.
namespace config::rows {

/// One word of an enumeration.
template <class Enumeration>
struct Word {
  std::string_view text;
  Enumeration value;
};

/// Puts a value that has passed its option into a field.
template <class Field>
void put(const Value& value, Field& field) {
  if constexpr (std::is_same_v<Field, bool>) {
    field = flag(value);
  } else if constexpr (std::is_integral_v<Field>) {
    field = whole<Field>(value);
  } else if constexpr (std::is_floating_point_v<Field>) {
    field = real(value);
  } else {
    field = words(value);
  }
}

/// What a field holds, as a value.
template <class Field>
Value value_of(const Field& field) {
  if constexpr (std::is_integral_v<Field> && !std::is_same_v<Field, bool>) {
    return scalar_value(static_cast<std::int64_t>(field));
  } else {
    return scalar_value(field);
  }
}

/// A row of a boolean, a whole or real number, or a string. `Get` is a captureless lambda that takes the
/// draft and returns a reference to the field.
template <class Get>
struct FieldRow {
  Option option;

  template <class Draft>
  constexpr operator Row<Draft>() const {
    return {option, [](Draft& draft, const Value& value) { put(value, Get{}(draft)); }, nullptr,
            [](Draft& draft) { return value_of(Get{}(draft)); }};
  }
};

/// A row of a duration; `Unit` is what the option counts in.
template <class Unit, class Get>
struct DurationRow {
  Option option;

  template <class Draft>
  constexpr operator Row<Draft>() const {
    return {option,
            [](Draft& draft, const Value& value) { Get{}(draft) = Unit(whole<typename Unit::rep>(value)); },
            nullptr,
            [](Draft& draft) { return value_of(std::chrono::duration_cast<Unit>(Get{}(draft)).count()); }};
  }
};

/// A row of an enumeration; `kWords` is an array of `Word`, all of its enumerators.
template <const auto& kWords, class Get>
struct ChoiceRow {
  Option option;

  template <class Draft>
  constexpr operator Row<Draft>() const {
    return {option,
            [](Draft& draft, const Value& value) {
              for (const auto& word : kWords) {
                if (word.text == words(value)) Get{}(draft) = word.value;
              }
            },
            nullptr,
            [](Draft& draft) {
              std::string text;
              for (const auto& word : kWords) {
                if (word.value == Get{}(draft)) text = word.text;
              }
              return scalar_value(std::move(text));
            }};
  }
};

template <class Get>
constexpr FieldRow<Get> field(Get /*get*/, const Option& option) {
  return {option};
}

template <class Unit, class Get>
constexpr DurationRow<Unit, Get> duration(Get /*get*/, const Option& option) {
  return {option};
}

/// The words of `kWords`, separated by '|', as `Option::choices` wants them.
template <const auto& kWords>
struct Joined {
  static constexpr std::size_t length() {
    std::size_t sum = 0;
    for (const auto& word : kWords) sum += word.text.size() + 1;
    return sum - 1;
  }
  static constexpr std::array<char, length()> text = [] {
    std::array<char, length()> out = {};
    std::size_t at = 0;
    for (const auto& word : kWords) {
      if (at != 0) out[at++] = '|';
      for (const char c : word.text) out[at++] = c;
    }
    return out;
  }();
};

template <const auto& kWords, class Get>
constexpr ChoiceRow<kWords, Get> chosen(Get /*get*/, Option option) {
  option.type = OptionType::choice;
  option.choices = {Joined<kWords>::text.data(), Joined<kWords>::text.size()};
  return {option};
}

// --- options whose default is their field's

constexpr Option boolean(std::string_view key, std::string_view help) {
  return boolean(key, "", help);
}

constexpr Option whole_number(std::string_view key, std::int64_t minimum, std::int64_t maximum,
                              std::string_view unit, std::string_view help) {
  return whole_number(key, "", minimum, maximum, unit, help);
}

constexpr Option real_number(std::string_view key, bool not_zero, std::string_view help) {
  return real_number(key, "", not_zero, help);
}

constexpr Option string(std::string_view key, OptionType type, std::int64_t minimum, std::int64_t maximum,
                        std::string_view help) {
  return string(key, type, "", minimum, maximum, help);
}

constexpr Option one_number(std::string_view key, std::string_view choices, std::string_view unit,
                            std::string_view help) {
  return one_number(key, "", choices, unit, help);
}

/// Its words come with `chosen`.
constexpr Option word(std::string_view key, std::string_view help) {
  return choice(key, "", "", help);
}

}  // namespace config::rows
