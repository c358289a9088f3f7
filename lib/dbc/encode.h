#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "dbc/database.h"

/// From values to bytes, and to the digits that give the same bytes again: the other way round than
/// `read_signals`.
namespace dbc {

/// The bits of a value in the signal's unit, rounded to the nearest that there is; nothing: it is out of
/// range, or no number.
std::optional<std::uint64_t> raw_of(const Signal& signal, double value) noexcept;
/// The bits of a number as people write it, whole numbers of 64 bits included; nothing: it is out of range,
/// or no number.
std::optional<std::uint64_t> raw_of_digits(const Signal& signal, std::string_view digits) noexcept;
/// The bits of a named value; nothing: the signal has no such name.
std::optional<std::uint64_t> raw_of(const Signal& signal, std::string_view word) noexcept;
/// Lowest and highest value of the signal, in its unit.
std::pair<double, double> range_of(const Signal& signal) noexcept;

/// Puts the signal's bits into `data`; all others stay. False: it does not lie in `data`, which is unchanged.
bool write_bits(const Signal& signal, std::uint64_t raw, std::span<std::uint8_t> data) noexcept;

/// Lets the multiplexors of the signal choose it, as far as they do not in these data.
void choose(const Message& message, const Signal& signal, std::span<std::uint8_t> data) noexcept;

/// The value in digits, as many as give the same raw value again, 10 at least, and to a thousandth of a step of a
/// scaled value; a text as it is.
std::string value_text(const Reading& reading);

}  // namespace dbc
