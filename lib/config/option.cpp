#include "config/option.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "config/shown.h"
#include "text/given_name.h"

namespace config {
namespace {

std::vector<std::string_view> split(std::string_view choices) {
  std::vector<std::string_view> out;
  while (!choices.empty()) {
    const std::size_t end = std::min(choices.find('|'), choices.size());
    out.push_back(choices.substr(0, end));
    choices.remove_prefix(std::min(end + 1, choices.size()));
  }
  return out;
}

bool is_choice(const Option& option, std::string_view text) {
  const auto all = split(option.choices);
  return std::find(all.begin(), all.end(), text) != all.end();
}

std::string choices_text(const Option& option, std::string_view last) {
  const auto all = split(option.choices);
  const std::string_view quote = option.type == OptionType::integer ? "" : "\"";
  std::string out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0) out += i + 1 == all.size() ? last : ", ";
    out += fmt::format("{0}{1}{0}", quote, all[i]);
  }
  return out;
}

bool is_identifier(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return (c < 0x80 && std::isalnum(c) != 0) || c == '_' || c == '.' || c == '-';
  });
}

bool is_name(std::string_view text) {
  const bool printable =
      std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  const bool blank_edge = text.starts_with(' ') || text.ends_with(' ');
  return printable && !blank_edge && text::is_given_name(text);
}

bool takes_string(const Option& option, const Value& value) {
  const auto* text = scalar<std::string>(value);
  if (text == nullptr) return false;
  const auto size = static_cast<std::int64_t>(text->size());
  if (size < option.minimum || size > option.maximum) return false;
  if (option.type == OptionType::identifier) return is_identifier(*text);
  if (option.type == OptionType::name) return is_name(*text) && !is_choice(option, *text);
  return true;
}

bool takes_integer(const Option& option, const Value& value) {
  const auto* number = scalar<std::int64_t>(value);
  if (number == nullptr) return false;
  if (!option.choices.empty()) return is_choice(option, std::to_string(*number));
  return *number >= option.minimum && *number <= option.maximum;
}

bool takes_number(const Option& option, const Value& value) {
  double number = 0;
  if (const auto* integer = scalar<std::int64_t>(value)) {
    number = static_cast<double>(*integer);
  } else if (const auto* real = scalar<double>(value)) {
    number = *real;
  } else {
    return false;
  }
  return std::isfinite(number) && (number != 0 || !option.not_zero);
}

}  // namespace

Table::Table(std::span<const Section> sections, std::vector<Option> options)
    : sections_(sections.begin(), sections.end()), options_(std::move(options)) {
  for (const Option& option : options_) {
    if (find_section(option.section()) == nullptr) {
      throw std::logic_error(fmt::format("option {} has no section", option.key));
    }
  }
  std::stable_sort(options_.begin(), options_.end(),
                   [&](const Option& a, const Option& b) { return place_of(a) < place_of(b); });
  for (const Section& section : sections_) {
    if (!section.numbers.empty() && find(fmt::format("{}.number", section.name)) == nullptr) {
      throw std::logic_error(fmt::format("section {} has no option number", section.name));
    }
  }
}

const Option* Table::find(std::string_view key) const noexcept {
  const auto found =
      std::find_if(options_.begin(), options_.end(), [&](const Option& option) { return option.key == key; });
  return found == options_.end() ? nullptr : &*found;
}

const Section* Table::find_section(std::string_view name) const noexcept {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const Section& section) { return section.name == name; });
  return found == sections_.end() ? nullptr : &*found;
}

bool Table::is_numbered(std::string_view section) const noexcept {
  const Section* found = find_section(section);
  return found != nullptr && !found->numbers.empty();
}

std::size_t Table::place_of(const Option& option) const noexcept {
  const auto found = std::find_if(sections_.begin(), sections_.end(),
                                  [&](const Section& section) { return section.name == option.section(); });
  return static_cast<std::size_t>(found - sections_.begin());
}

std::string title(const Section& section) {
  return section.numbers.empty() ? fmt::format("[{}]", section.name) : fmt::format("[[{}]]", section.name);
}

std::string allowed(const Option& option) {
  const std::string unit = option.unit.empty() ? "" : fmt::format(" {}", option.unit);
  switch (option.type) {
    case OptionType::text:
      return fmt::format("a string of {}..{} bytes", option.minimum, option.maximum);
    case OptionType::identifier:
      return fmt::format("{}..{} letters, digits, '_', '.' or '-', in quotes", option.minimum,
                         option.maximum);
    case OptionType::name: {
      const std::string reserved =
          option.choices.empty() ? "" : fmt::format("none of {}, ", choices_text(option, ", "));
      return fmt::format("a string of {}..{} bytes, {}, no control character, {}no blank at its ends",
                         option.minimum, option.maximum, text::kGivenNameWords, reserved);
    }
    case OptionType::integer:
      return (option.choices.empty() ? fmt::format("{}..{}", option.minimum, option.maximum)
                                     : choices_text(option, " or ")) +
             unit;
    case OptionType::number:
      return option.not_zero ? "a finite number other than 0" : "a finite number";
    case OptionType::boolean:
      return "true or false";
    case OptionType::choice:
      return choices_text(option, " or ");
    case OptionType::other:
      return std::string(option.words);
  }
  return "";
}

bool takes(const Option& option, const Value& value) {
  switch (option.type) {
    case OptionType::text:
    case OptionType::identifier:
    case OptionType::name:
      return takes_string(option, value);
    case OptionType::integer:
      return takes_integer(option, value);
    case OptionType::number:
      return takes_number(option, value);
    case OptionType::boolean:
      return scalar<bool>(value) != nullptr;
    case OptionType::choice: {
      const auto* word = scalar<std::string>(value);
      return word != nullptr && is_choice(option, *word);
    }
    case OptionType::other:
      return true;
  }
  return false;
}

std::string mismatch_text(const Option& option, const Value& value) {
  return fmt::format("found {}; allowed: {}", shown(value.text), allowed(option));
}

}  // namespace config
