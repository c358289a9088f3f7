#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "profile/profile.h"

/// Raw values and values in engineering units. Pure functions; any thread; they allocate.
namespace profile {

/// Has a value of this width, as the slave has it, the format of the profile? What the profile says of a parameter holds for
/// no other: after an update of the drive's firmware it may have another width.
constexpr bool fits_format(const Parameter& parameter, bool doubleword) noexcept {
  return doubleword == (parameter.format == Format::doubleword);
}

/// The raw number a value on the bus stands for: two's complement when the parameter is signed.
std::int64_t raw_number(const Parameter& parameter, std::uint32_t raw) noexcept;

/// Smallest and greatest raw number the format holds.
std::int64_t format_minimum(const Parameter& parameter) noexcept;
std::int64_t format_maximum(const Parameter& parameter) noexcept;

/// The value in engineering units.
double scaled(const Parameter& parameter, std::int64_t number) noexcept;

/// The same as text without the unit: as many decimals as one step of the raw value needs, so that `to_raw`
/// gives the same raw value back.
std::string scaled_text(const Parameter& parameter, std::int64_t number);

/// "1..2147483647": the limits in engineering units, the smaller one first; empty when the profile gives
/// none.
std::string limits_text(const Parameter& parameter);

/// "maximum-speed (parameter 401)".
std::string label(const Parameter& parameter);

/// Why something is not possible: what was found, and what is allowed.
struct Refused {
  std::string text;
};

/// The raw value on the bus that is nearest to a number in engineering units, such as "12.5" or "-3e2".
/// Refused when `text` is no number or the format cannot hold it; limits are not looked at.
std::variant<std::uint32_t, Refused> to_raw(const Parameter& parameter, std::string_view text);

/// Why `raw` may not be written: access, format or limits; nothing when it may.
std::optional<Refused> write_problem(const Parameter& parameter, std::uint32_t raw);

/// Why the parameter may not be read; nothing when it may.
std::optional<Refused> read_problem(const Parameter& parameter);

/// "word" or "doubleword".
std::string_view name(Format format) noexcept;
/// "read-write", "read-only" or "none".
std::string_view name(Access access) noexcept;

}  // namespace profile
