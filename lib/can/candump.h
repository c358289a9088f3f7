#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "can/frame.h"

/// One line of what candump writes. The text log that `candump -L` writes: `(seconds.micros) interface identifier#data`;
/// stamps may have nine digits of nanoseconds (-N), or a date (-tA), which is taken in this computer's time zone.
/// An identifier of 3 digits is standard, of 8 digits extended; `R` instead of data marks a remote frame;
/// bit 29 of an 8-digit identifier an error frame. And what `candump` shows on a screen:
/// `(seconds.micros)  interface  identifier  [length]  bytes`, where the time may be missing.
namespace can {

/// Longest interface name, in characters, that readers of the log take.
inline constexpr std::size_t kInterfaceNameLimit = 15;
/// Most characters of one line, line feed included.
inline constexpr std::size_t kCandumpLineLimit = 80;

/// A parsed line.
struct CandumpLine {
  std::chrono::microseconds time{};  ///< the line's time stamp
  std::string interface;             ///< 1..15 characters
  Frame frame;
};

/// Why a text is no such line or frame.
struct CandumpError {
  std::size_t column = 0;  ///< where it goes wrong, from 1
  std::string message;     ///< what was found and what is allowed
};

/// Writes one line with its line feed into `out` and returns the number of characters. Negative times are
/// written as 0; of `interface` at most 15 characters are taken; a data length over 8 counts as 8.
/// Does not allocate or throw.
std::size_t write_candump_line(std::chrono::microseconds time, std::string_view interface, const Frame& frame,
                               std::span<char, kCandumpLineLimit> out) noexcept;

/// True when `name` can stand as the interface of a line: 1..15 printable characters without a space.
bool is_interface_name(std::string_view name) noexcept;

/// Parses one line of either form, with or without its line feed; a last word `R` or `T` (direction) is allowed
/// in the log, what candump adds behind the bytes on a screen. Without a time stamp the time is 0.
std::variant<CandumpLine, CandumpError> parse_candump_line(std::string_view line);

/// Parses the frame alone, as `identifier#data`.
std::variant<Frame, CandumpError> parse_candump_frame(std::string_view text);

}  // namespace can
