#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

/// Reading what a person types: numbers, slave sets, mappings. Everything here throws `UsageError` with what
/// was found and what is allowed. Not for the realtime thread.
namespace cansync::cli {

/// The command line is wrong; the text says what was found, what is allowed and, where it helps, the remedy.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Width of a raw value on the bus.
enum class Width : std::uint8_t {
  word,        ///< 16 bits
  doubleword,  ///< 32 bits
};

/// A whole number, decimal or hexadecimal (`0x`, also `-0x`), in `minimum`..`maximum`; nothing else may stand
/// in `text`. `what` names the argument in the error.
std::int64_t parse_integer(std::string_view text, std::string_view what, std::int64_t minimum,
                           std::int64_t maximum);

/// True when `text` begins like a number: a digit, or a sign before a digit.
bool looks_like_number(std::string_view text) noexcept;

/// A raw value of `width`: 0..65535 or 0..4294967295; negative ones down to -32768 or -2147483648 become
/// their two's complement of that width.
std::uint32_t parse_raw(std::string_view text, std::string_view what, Width width);

/// `raw` of `width` read as two's complement.
std::int32_t as_signed(std::uint32_t raw, Width width) noexcept;

/// A finite number with a decimal point if wanted ("12.5", "-3e2").
double parse_real(std::string_view text, std::string_view what);

/// A mask of slaves in hexadecimal, "0x00000001" to "0xFFFFFFFF"; bit n = slave n.
std::uint32_t parse_slave_mask(std::string_view text);

/// "0,2-4" for 0b11101; "-" for none.
std::string format_slave_set(std::uint32_t mask);

/// Which of eight values a name means; nothing when unknown.
using ValueLookup = std::function<std::optional<unsigned>(std::string_view name)>;

/// A value by number 0..7, as "valueN", or by its configured name.
unsigned parse_value_number(std::string_view text, const ValueLookup& lookup);

/// The register byte of one mapped word (M 3.1.1.1): the byte itself ("0x0D"), "NAME.low" or "NAME.high" with
/// a value by number, "valueN" or name, or "-" for an unused word.
std::uint8_t parse_mapping_word(std::string_view text, const ValueLookup& lookup);

/// "value3.low" for 0x0D, "-" for 0, hexadecimal for a byte that is no mapping.
std::string format_mapping_word(std::uint8_t byte);

/// One `VALUE=NUMBER` of `set`, cut at the first '='; both sides are not empty.
struct Assignment {
  std::string value;
  std::string number;
};
Assignment parse_assignment(std::string_view text);

/// Raw value whose scaled value is nearest to `scaled`: (scaled - offset) / factor, rounded. Throws when the
/// result does not fit 32 bits signed, or `factor` is 0.
std::int32_t unscale(double scaled, double factor, double offset, std::string_view what);

}  // namespace cansync::cli
