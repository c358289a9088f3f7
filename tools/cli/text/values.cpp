#include "cli/text/values.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>

#include "cli/text/slave_list.h"
#include "text/given_name.h"

namespace cansync::cli {
namespace {

constexpr unsigned kValues = 8;

[[noreturn]] void refuse(std::string_view what, std::string_view found, std::string_view allowed) {
  throw UsageError(fmt::format("{}: found '{}'; allowed: {}", what, found, allowed));
}

/// Sign and digits of a whole number; nothing when `text` is none or does not fit 64 bits.
std::optional<std::int64_t> to_integer(std::string_view text) noexcept {
  const bool negative = text.starts_with('-');
  if (negative || text.starts_with('+')) text.remove_prefix(1);
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    base = 16;
    text.remove_prefix(2);
  }
  std::uint64_t digits = 0;
  const auto* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, digits, base);
  constexpr auto limit = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (text.empty() || error != std::errc{} || stop != end || digits > limit) return std::nullopt;
  const auto number = static_cast<std::int64_t>(digits);
  return negative ? -number : number;
}

}  // namespace

bool looks_like_number(std::string_view text) noexcept {
  return text::begins_as_number(text);
}

std::int64_t parse_integer(std::string_view text, std::string_view what, std::int64_t minimum,
                           std::int64_t maximum) {
  const auto number = to_integer(text);
  if (!number || *number < minimum || *number > maximum)
    refuse(what, text, fmt::format("{}..{}, decimal or hexadecimal (0x..)", minimum, maximum));
  return *number;
}

std::uint32_t parse_raw(std::string_view text, std::string_view what, Width width) {
  const bool word = width == Width::word;
  const std::int64_t minimum =
      word ? std::numeric_limits<std::int16_t>::min() : std::numeric_limits<std::int32_t>::min();
  const std::int64_t maximum =
      word ? std::numeric_limits<std::uint16_t>::max() : std::numeric_limits<std::uint32_t>::max();
  const std::int64_t number = parse_integer(text, what, minimum, maximum);
  const auto raw = static_cast<std::uint32_t>(number);  // modulo 2^32: the two's complement
  return word ? raw & 0xFFFFu : raw;
}

std::int32_t as_signed(std::uint32_t raw, Width width) noexcept {
  return width == Width::word ? static_cast<std::int16_t>(raw & 0xFFFFu) : static_cast<std::int32_t>(raw);
}

double parse_real(std::string_view text, std::string_view what) {
  std::string_view digits = text;
  if (digits.starts_with('+')) digits.remove_prefix(1);
  double number = 0.0;
  const auto* end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, number);
  if (digits.empty() || error != std::errc{} || stop != end || !std::isfinite(number))
    refuse(what, text, "a number such as 12.5 or -3e2");
  return number;
}

std::uint32_t parse_slave_mask(std::string_view text) {
  const auto mask = to_integer(text);
  if (!mask || *mask < 1 || *mask > 0xFFFFFFFFll) {
    refuse("slaves", text,
           "a mask of 0x00000001..0xFFFFFFFF, or a list of slave numbers, ranges and names such as 0,4-7");
  }
  return static_cast<std::uint32_t>(*mask);
}

std::string format_slave_set(std::uint32_t mask) {
  std::string text;
  for (unsigned slave = 0; slave < kSlaves;) {
    if (((mask >> slave) & 1u) == 0) {
      ++slave;
      continue;
    }
    const unsigned first = slave;
    while (slave < kSlaves && ((mask >> slave) & 1u) != 0) ++slave;
    if (!text.empty()) text += ',';
    text += slave - first == 1 ? fmt::format("{}", first) : fmt::format("{}-{}", first, slave - 1);
  }
  return text.empty() ? "-" : text;
}

unsigned parse_value_number(std::string_view text, const ValueLookup& lookup) {
  if (const auto named = lookup(text)) return *named;
  constexpr std::string_view prefix = "value";
  const auto digits = text.starts_with(prefix) ? text.substr(prefix.size()) : text;
  const auto number = to_integer(digits);
  if (!looks_like_number(digits) || !number || *number < 0 || *number >= kValues)
    refuse("value", text, "0..7, value0..value7, or a configured name");
  return static_cast<unsigned>(*number);
}

std::uint8_t parse_mapping_word(std::string_view text, const ValueLookup& lookup) {
  if (text == "-") return 0;
  constexpr std::string_view allowed =
      "VALUE.low or VALUE.high (VALUE: 0..7, value0..value7 or a configured name), a register byte such as "
      "0x0D, or - for an unused word";
  if (text.starts_with("0x") || text.starts_with("0X")) {
    const auto byte = to_integer(text);
    const bool mapping = byte && *byte >= 0 && *byte <= 0x1F;
    if (!mapping || ((*byte & 1) == 0 && *byte != 0)) refuse("mapping word", text, allowed);
    return static_cast<std::uint8_t>(*byte);
  }
  const auto dot = text.rfind('.');
  const auto half = dot == std::string_view::npos ? std::string_view{} : text.substr(dot + 1);
  if (half != "low" && half != "high") refuse("mapping word", text, allowed);
  const unsigned value = parse_value_number(text.substr(0, dot), lookup);
  return static_cast<std::uint8_t>(1u | (half == "high" ? 2u : 0u) | (value << 2));
}

std::string format_mapping_word(std::uint8_t byte) {
  if (byte == 0) return "-";
  if ((byte & 1u) == 0 || (byte >> 2) >= kValues) return fmt::format("0x{:02X}", byte);
  return fmt::format("value{}.{}", byte >> 2, (byte & 2u) != 0 ? "high" : "low");
}

Assignment parse_assignment(std::string_view text) {
  const auto equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0 || equals + 1 == text.size())
    refuse("reference value", text, "VALUE=NUMBER, for example 0=1000");
  return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

std::int64_t raw_number(std::uint32_t raw, RawForm form) noexcept {
  if (form.is_signed) return as_signed(raw, form.width);
  return form.width == Width::word ? raw & 0xFFFFu : raw;
}

std::int64_t unscale(double scaled, double factor, double offset, RawForm form, std::string_view what) {
  if (factor == 0.0) throw UsageError(fmt::format("{}: its factor is 0, so it has no scaled value", what));
  const double number = std::round((scaled - offset) / factor);
  const int bits = form.width == Width::word ? 16 : 32;
  const double minimum = form.is_signed ? -std::ldexp(1.0, bits - 1) : 0.0;
  const double maximum = std::ldexp(1.0, form.is_signed ? bits - 1 : bits) - 1.0;
  if (!(number >= minimum && number <= maximum)) {
    const double one = minimum * factor + offset;
    const double other = maximum * factor + offset;
    throw UsageError(fmt::format("{}: found '{}'; allowed: {:g}..{:g}{}", what, scaled, std::min(one, other),
                                 std::max(one, other),
                                 bits == 16 ? ", because its low word alone is mapped" : ""));
  }
  return static_cast<std::int64_t>(number);
}

}  // namespace cansync::cli
