#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "dbc/database.h"

/// From values to bytes: the other way round than `read_signals`.
namespace dbc {

/// The bits of a value in the signal's unit, rounded to the nearest that there is; nothing: it is out of
/// range, or no number.
std::optional<std::uint64_t> raw_of(const Signal& signal, double value) noexcept;
/// The bits of a named value; nothing: the signal has no such name.
std::optional<std::uint64_t> raw_of(const Signal& signal, std::string_view word) noexcept;
/// Lowest and highest value of the signal, in its unit.
std::pair<double, double> range_of(const Signal& signal) noexcept;

/// Puts the signal's bits into `data`; all others stay. False: it does not lie in `data`, which is unchanged.
bool write_bits(const Signal& signal, std::uint64_t raw, std::span<std::uint8_t> data) noexcept;

}  // namespace dbc
