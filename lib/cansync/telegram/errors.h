#pragma once

#include <cstdint>
#include <string_view>

/// Error codes that slaves answer with, by name (M 3.2.2.6).
namespace cansync {

/// Error code of a parameter reply.
enum class ParameterError : std::uint16_t {
  none = 0x0000,
  unspecified = 0xFFFF,
  below_minimum = 0xFFFE,
  above_maximum = 0xFFFD,
  not_changeable = 0xFFFC,
  not_present = 0xFFFB,
  not_available_now = 0xFFFA,
  wrong_format = 0xFFF9,
};

/// Error code of a transfer reply.
enum class TransferError : std::uint16_t {
  none = 0x0000,
  wrong_block_acknowledged = 0x0001,
  longer_than_300_bytes = 0x0002,
  other_block_expected = 0x0100,
  end_expected = 0x0101,
  end_not_expected = 0x0102,
  cancelled_by_slave = 0x0103,
  not_possible = 0x0104,
  address_not_allowed = 0x0105,
  block_too_long = 0x0107,
  mode_not_allowed = 0x0108,
};

/// Meaning of an error code in words a service engineer understands; "unknown error code" for one not in the
/// manuals.
std::string_view meaning(ParameterError error) noexcept;
std::string_view meaning(TransferError error) noexcept;

}  // namespace cansync
