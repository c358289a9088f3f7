#include "daemon/config/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "daemon/config/option_rows.h"
#include "daemon/config/return_parameters.h"

namespace cansyncd {
namespace {

/// Words a slave's name cannot be, because options and commands take them in its place.
constexpr auto kReservedNames = std::to_array<std::string_view>({"automatic", "nobody", "all"});

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

std::string choices_text(const Option& option) {
  const auto all = split(option.choices);
  const std::string_view quote = option.type == OptionType::choice ? "\"" : "";
  std::string out;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i > 0) out += i + 1 == all.size() ? " or " : ", ";
    out += fmt::format("{0}{1}{0}", quote, all[i]);
  }
  return out;
}

bool is_number(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  if (text.empty()) return false;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    text.remove_prefix(2);
    return !text.empty() &&
           std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isxdigit(c); });
  }
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
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
  const bool reserved = std::find(kReservedNames.begin(), kReservedNames.end(), text) != kReservedNames.end();
  return printable && !blank_edge && !reserved && !is_number(text);
}

bool takes_string(const Option& option, const Value& value) {
  const auto* text = scalar<std::string>(value);
  if (text == nullptr) return false;
  const auto size = static_cast<std::int64_t>(text->size());
  if (size < option.minimum || size > option.maximum) return false;
  if (option.type == OptionType::identifier) return is_identifier(*text);
  if (option.type == OptionType::name) return is_name(*text);
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

bool takes_cursor(const Value& value, const Draft& draft) {
  if (value.kind != Value::Kind::scalar) return false;
  const auto* word = scalar<std::string>(value);
  if (word != nullptr && (*word == "automatic" || *word == "nobody")) return true;
  return find_slave(draft.config, value.items.front()).has_value();
}

bool takes_slaves(const Value& value, const Draft& draft) {
  return value.kind == Value::Kind::list &&
         std::all_of(value.items.begin(), value.items.end(),
                     [&](const Scalar& item) { return find_slave(draft.config, item).has_value(); });
}

bool takes_four_numbers(const Value& value, std::int64_t minimum, std::int64_t maximum) {
  return value.kind == Value::Kind::list && value.items.size() == cansync::kWords &&
         std::all_of(value.items.begin(), value.items.end(), [&](const Scalar& item) {
           const auto* number = std::get_if<std::int64_t>(&item);
           return number != nullptr && *number >= minimum && *number <= maximum;
         });
}

bool takes_four_flags(const Value& value) {
  return value.kind == Value::Kind::list && value.items.size() == cansync::kWords &&
         std::all_of(value.items.begin(), value.items.end(),
                     [](const Scalar& item) { return std::holds_alternative<bool>(item); });
}

bool takes(const Option& option, const Value& value, const Draft& draft) {
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
    case OptionType::cursor:
      return takes_cursor(value, draft);
    case OptionType::slaves:
      return takes_slaves(value, draft);
    case OptionType::registers:
      return takes_four_numbers(value, 0, 127);
    case OptionType::value_numbers:
      return takes_four_numbers(value, -1, cansync::kValues - 1);
    case OptionType::flags:
      return takes_four_flags(value);
    case OptionType::parameter_values:
      return takes_return_parameters(value);
  }
  return false;
}

}  // namespace

std::span<const Option> options() {
  static const std::vector<Option> all = [] {
    std::vector<Option> out(rows::daemon_options().begin(), rows::daemon_options().end());
    out.insert(out.end(), rows::failsafe_options().begin(), rows::failsafe_options().end());
    out.insert(out.end(), rows::access_options().begin(), rows::access_options().end());
    out.insert(out.end(), rows::metrics_options().begin(), rows::metrics_options().end());
    out.insert(out.end(), rows::sync_options().begin(), rows::sync_options().end());
    out.insert(out.end(), rows::line_options().begin(), rows::line_options().end());
    for (const Option& option : rows::slave_options()) {
      // Behind the others of its section.
      const std::string_view section = option.key.substr(0, option.key.find('.') + 1);
      const auto last = std::find_if(out.rbegin(), out.rend(), [&](const Option& o) {
        return o.key.starts_with(section) && o.key.find('.', section.size()) == std::string_view::npos;
      });
      out.insert(last.base(), option);
    }
    return out;
  }();
  return all;
}

const Option* find_option(std::string_view key) {
  for (const Option& option : options()) {
    if (option.key == key) return &option;
  }
  return nullptr;
}

bool is_section(std::string_view key) {
  return std::any_of(options().begin(), options().end(), [&](const Option& option) {
    return option.key.starts_with(key) && option.key.substr(key.size()).starts_with('.');
  });
}

bool is_repeated(std::string_view section) {
  return section == "slave" || section == "slave.value" || section == "actual" || section == "reference";
}

std::string allowed(const Option& option) {
  const std::string unit = option.unit.empty() ? "" : fmt::format(" {}", option.unit);
  switch (option.type) {
    case OptionType::text:
      return fmt::format("a string of {}..{} bytes", option.minimum, option.maximum);
    case OptionType::identifier:
      return fmt::format("{}..{} letters, digits, '_', '.' or '-', in quotes", option.minimum,
                         option.maximum);
    case OptionType::name:
      return fmt::format(
          "a string of {}..{} bytes, no number, none of \"automatic\", \"nobody\", \"all\", no blank at its "
          "ends",
          option.minimum, option.maximum);
    case OptionType::integer:
      return (option.choices.empty() ? fmt::format("{}..{}", option.minimum, option.maximum)
                                     : choices_text(option)) +
             unit;
    case OptionType::number:
      return option.not_zero ? "a finite number other than 0" : "a finite number";
    case OptionType::boolean:
      return "true or false";
    case OptionType::choice:
      return choices_text(option);
    case OptionType::cursor:
      return "\"automatic\", \"nobody\", or number or name of a configured slave";
    case OptionType::slaves:
      return "a list of numbers or names of configured slaves";
    case OptionType::registers:
      return "a list of four numbers 0..127";
    case OptionType::value_numbers:
      return "a list of four numbers -1..7";
    case OptionType::flags:
      return "a list of four times true or false";
    case OptionType::parameter_values:
      return fmt::format(
          "a list of at most {} strings \"NUMBER=VALUE\", numbers 0..4095 each once, values 0..4294967295",
          cansync::kReturnParameters);
  }
  return "";
}

std::optional<std::string> mismatch(const Option& option, const Value& value, const Draft& draft) {
  if (takes(option, value, draft)) return std::nullopt;
  return fmt::format("found {}; allowed: {}", value.text, allowed(option));
}

std::optional<cansync::SlaveNumber> find_slave(const Config& config, const Scalar& who) {
  const auto configured = [&](std::uint64_t number) { return config.master.slaves[number].configured; };
  if (const auto* number = std::get_if<std::int64_t>(&who)) {
    if (*number < 0 || *number >= cansync::kSlaves || !configured(static_cast<std::uint64_t>(*number))) {
      return std::nullopt;
    }
    return cansync::SlaveNumber::from(static_cast<std::uint64_t>(*number));
  }
  const auto* name = std::get_if<std::string>(&who);
  if (name == nullptr) return std::nullopt;
  for (unsigned n = 0; n < cansync::kSlaves; ++n) {
    if (configured(n) && config.slaves[n].name == *name) return cansync::SlaveNumber::from(n);
  }
  return std::nullopt;
}

cansync::Cursor to_cursor(const Config& config, const Value& value) {
  using Kind = cansync::Cursor::Kind;
  if (const auto* word = scalar<std::string>(value)) {
    if (*word == "automatic") return {Kind::automatic, {}};
    if (*word == "nobody") return {Kind::nobody, {}};
  }
  const auto slave = find_slave(config, value.items.front());
  return slave ? cansync::Cursor{Kind::fixed, *slave} : cansync::Cursor{Kind::nobody, {}};
}

}  // namespace cansyncd
