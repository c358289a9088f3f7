#include "profile/scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

namespace profile {
namespace {

constexpr int kMostDecimals = 9;

/// Decimals that write `number` exactly; nothing when there are more than `kMostDecimals`.
std::optional<int> decimals_of(double number) {
  std::string text = fmt::format("{:.{}f}", number, kMostDecimals);
  double back = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), back);
  if (back != number) return std::nullopt;
  const std::size_t point = text.find('.');
  const std::size_t last = text.find_last_not_of('0');
  return static_cast<int>(last - point);
}

std::string_view unit_gap(const Parameter& parameter) {
  return parameter.unit.empty() ? "" : " ";
}

std::string allowed_range(const Parameter& parameter, std::int64_t minimum, std::int64_t maximum) {
  if (parameter.factor < 0.0) std::swap(minimum, maximum);
  return fmt::format("{}..{}{}{}", scaled_text(parameter, minimum), scaled_text(parameter, maximum),
                     unit_gap(parameter), parameter.unit);
}

std::string format_range(const Parameter& parameter) {
  return fmt::format("{} (all that a {} holds)",
                     allowed_range(parameter, format_minimum(parameter), format_maximum(parameter)),
                     name(parameter.format));
}

}  // namespace

std::string_view name(Format format) noexcept {
  return format == Format::word ? "word" : "doubleword";
}

std::string_view name(Access access) noexcept {
  switch (access) {
    case Access::read_write:
      return "read-write";
    case Access::read_only:
      return "read-only";
    case Access::none:
      break;
  }
  return "none";
}

std::int64_t raw_number(const Parameter& parameter, std::uint32_t raw) noexcept {
  if (parameter.format == Format::word) {
    const auto word = static_cast<std::uint16_t>(raw);
    return parameter.is_signed ? std::int64_t{static_cast<std::int16_t>(word)} : std::int64_t{word};
  }
  return parameter.is_signed ? std::int64_t{static_cast<std::int32_t>(raw)} : std::int64_t{raw};
}

std::int64_t format_minimum(const Parameter& parameter) noexcept {
  if (!parameter.is_signed) return 0;
  return parameter.format == Format::word ? std::numeric_limits<std::int16_t>::min()
                                          : std::numeric_limits<std::int32_t>::min();
}

std::int64_t format_maximum(const Parameter& parameter) noexcept {
  if (parameter.format == Format::word) {
    return parameter.is_signed ? std::numeric_limits<std::int16_t>::max()
                               : std::numeric_limits<std::uint16_t>::max();
  }
  return parameter.is_signed ? std::int64_t{std::numeric_limits<std::int32_t>::max()}
                             : std::int64_t{std::numeric_limits<std::uint32_t>::max()};
}

double scaled(const Parameter& parameter, std::int64_t number) noexcept {
  return static_cast<double>(number) * parameter.factor + parameter.offset;
}

std::string scaled_text(const Parameter& parameter, std::int64_t number) {
  const double value = scaled(parameter, number);
  const auto of_factor = decimals_of(parameter.factor);
  const auto of_offset = decimals_of(parameter.offset);
  if (of_factor && of_offset) {
    std::string text = fmt::format("{:.{}f}", value, std::max(*of_factor, *of_offset));
    // -0.0 is no value of its own.
    return text.find_first_not_of("-0.") == std::string::npos && text.starts_with('-') ? text.substr(1)
                                                                                       : text;
  }
  constexpr int kFewest = 6;
  for (int digits = kFewest; digits < std::numeric_limits<double>::max_digits10; ++digits) {
    std::string text = fmt::format("{:.{}g}", value, digits);
    double back = 0.0;
    std::from_chars(text.data(), text.data() + text.size(), back);
    if (std::llround((back - parameter.offset) / parameter.factor) == number) return text;
  }
  return fmt::format("{}", value);
}

std::string limits_text(const Parameter& parameter) {
  if (!parameter.limited) return "";
  std::int64_t first = parameter.minimum;
  std::int64_t last = parameter.maximum;
  if (parameter.factor < 0.0) std::swap(first, last);
  return scaled_text(parameter, first) + ".." + scaled_text(parameter, last);
}

std::string label(const Parameter& parameter) {
  return fmt::format("{} (parameter {})", parameter.name, parameter.number);
}

std::variant<std::uint32_t, Refused> to_raw(const Parameter& parameter, std::string_view text) {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double value = 0.0;
  const auto* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  if (digits.empty() || error != std::errc{} || stop != end || !std::isfinite(value)) {
    return Refused{fmt::format("{}: found '{}'; allowed: a number{}{}, such as 12.5 or -3e2",
                               label(parameter), text, parameter.unit.empty() ? "" : " in ", parameter.unit)};
  }
  const double number = std::round((value - parameter.offset) / parameter.factor);
  if (!(number >= static_cast<double>(format_minimum(parameter)) &&
        number <= static_cast<double>(format_maximum(parameter)))) {
    const std::string allowed = parameter.limited
                                    ? allowed_range(parameter, parameter.minimum, parameter.maximum)
                                    : format_range(parameter);
    return Refused{fmt::format("{}: found {}{}{}; allowed: {}", label(parameter), text, unit_gap(parameter),
                               parameter.unit, allowed)};
  }
  const auto raw = static_cast<std::uint32_t>(static_cast<std::int64_t>(number));
  return parameter.format == Format::word ? raw & 0xFFFFu : raw;
}

std::optional<Refused> read_problem(const Parameter& parameter) {
  if (parameter.access != Access::none) return std::nullopt;
  return Refused{fmt::format("{}: the profile has it with access none, neither to be read nor written",
                             label(parameter))};
}

std::optional<Refused> write_problem(const Parameter& parameter, std::uint32_t raw) {
  if (parameter.access == Access::none) return read_problem(parameter);
  if (parameter.access == Access::read_only) {
    return Refused{fmt::format("{}: read-only by the profile; it cannot be written", label(parameter))};
  }
  if (parameter.format == Format::word && raw > 0xFFFFu) {
    return Refused{
        fmt::format("{}: found raw value {}; allowed: 0..65535, it is a word", label(parameter), raw)};
  }
  const std::int64_t number = raw_number(parameter, raw);
  if (number >= parameter.minimum && number <= parameter.maximum) return std::nullopt;
  return Refused{fmt::format("{}: found {}{}{} (raw {}); allowed: {}", label(parameter),
                             scaled_text(parameter, number), unit_gap(parameter), parameter.unit, number,
                             allowed_range(parameter, parameter.minimum, parameter.maximum))};
}

}  // namespace profile
