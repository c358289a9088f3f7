#pragma once

#include <array>
#include <chrono>
#include <cstdint>

#include "can/frame.h"

/// SAE J1939 on a bus, sans-IO.
namespace j1939 {

/// An instant on the clock of the bus: nanoseconds since its arbitrary start.
using Time = std::chrono::nanoseconds;
/// Number of a parameter group, 0..kLargestPgn: extended data page, data page, PDU format, group extension.
using Pgn = std::uint32_t;
/// Address of a controller application: 0..253, kNullAddress or, of a destination, kGlobalAddress.
using Address = std::uint8_t;

inline constexpr Pgn kLargestPgn = 0x3FFFF;
/// Source of those who have no address.
inline constexpr Address kNullAddress = 254;
/// Destination of what is meant for all.
inline constexpr Address kGlobalAddress = 255;

/// Parameter groups that the data link and network management themselves need.
namespace pgn {
inline constexpr Pgn kAcknowledgement = 0x0E800;
inline constexpr Pgn kRequest = 0x0EA00;
inline constexpr Pgn kTransportData = 0x0EB00;
inline constexpr Pgn kTransportControl = 0x0EC00;
inline constexpr Pgn kAddressClaimed = 0x0EE00;
inline constexpr Pgn kExtendedTransportData = 0x0C700;
inline constexpr Pgn kExtendedTransportControl = 0x0C800;
inline constexpr Pgn kActiveFaults = 0x0FECA;         ///< DM1
inline constexpr Pgn kPreviousFaults = 0x0FECB;       ///< DM2
inline constexpr Pgn kErasePreviousFaults = 0x0FECC;  ///< DM3: who is asked for it erases them
inline constexpr Pgn kEraseActiveFaults = 0x0FED3;    ///< DM11: likewise
inline constexpr Pgn kCommandedAddress = 0x0FED8;
}  // namespace pgn

/// The 29 bits of an identifier as their fields, from the highest to the lowest.
struct Identifier {
  std::uint8_t priority = 6;        ///< 0..7, 0 is the most urgent
  bool extended_data_page = false;  ///< bit 25, the manual's reserved bit
  bool data_page = false;           ///< bit 24
  std::uint8_t format = 0;          ///< PF, 0..255: below 240 PDU1, else PDU2
  std::uint8_t specific = 0;        ///< PS, 0..255: destination (PDU1) or group extension (PDU2)
  Address source = 0;               ///< SA, 0..255

  friend bool operator==(const Identifier&, const Identifier&) = default;
};

/// Puts the fields together; of a larger priority the low three bits count. Realtime safe; any thread.
constexpr std::uint32_t compose(const Identifier& parts) noexcept {
  return (parts.priority & 7u) << 26 | (parts.extended_data_page ? 1u << 25 : 0u) |
         (parts.data_page ? 1u << 24 : 0u) | std::uint32_t{parts.format} << 16 |
         std::uint32_t{parts.specific} << 8 | parts.source;
}

/// Takes 29 bits apart. Realtime safe; any thread.
constexpr Identifier parse(std::uint32_t identifier) noexcept {
  return {static_cast<std::uint8_t>(identifier >> 26 & 7),
          (identifier >> 25 & 1) != 0,
          (identifier >> 24 & 1) != 0,
          static_cast<std::uint8_t>(identifier >> 16),
          static_cast<std::uint8_t>(identifier >> 8),
          static_cast<std::uint8_t>(identifier)};
}

/// A group of PDU1 is sent to one destination, or to all; one of PDU2 always to all.
constexpr bool has_destination(Pgn number) noexcept {
  return (number >> 8 & 0xFF) < 240;
}

/// True for the number of a group: in range, and with PDU1 its lowest byte is 0.
constexpr bool is_pgn(Pgn number) noexcept {
  return number <= kLargestPgn && (!has_destination(number) || (number & 0xFF) == 0);
}

/// Carried by the protocol itself, which alone sends them.
constexpr bool is_reserved(Pgn number) noexcept {
  return number == pgn::kTransportControl || number == pgn::kTransportData ||
         number == pgn::kExtendedTransportControl || number == pgn::kExtendedTransportData ||
         number == pgn::kAddressClaimed;
}

/// The group an identifier belongs to: with PDU1 without its destination.
constexpr Pgn pgn_of(const Identifier& parts) noexcept {
  const Pgn number =
      (parts.extended_data_page ? 1u << 17 : 0u) | (parts.data_page ? 1u << 16 : 0u) | Pgn{parts.format} << 8;
  return parts.format < 240 ? number : number | parts.specific;
}

/// Whom an identifier means: with PDU2 all.
constexpr Address destination_of(const Identifier& parts) noexcept {
  return parts.format < 240 ? parts.specific : kGlobalAddress;
}

/// The identifier of a group; `destination` counts with PDU1 alone. `number` must be one (`is_pgn`).
constexpr Identifier identifier_of(Pgn number, std::uint8_t priority, Address destination,
                                   Address source) noexcept {
  return {priority,
          (number >> 17 & 1) != 0,
          (number >> 16 & 1) != 0,
          static_cast<std::uint8_t>(number >> 8),
          has_destination(number) ? destination : static_cast<std::uint8_t>(number),
          source};
}

/// A data frame with these fields and bytes.
template <std::size_t N>
constexpr can::Frame frame_of(const Identifier& parts, const std::array<std::uint8_t, N>& bytes) noexcept {
  static_assert(N <= 8);
  can::Frame frame;
  frame.id = compose(parts);
  frame.extended = true;
  frame.dlc = N;
  for (std::size_t i = 0; i < N; ++i) frame.data[i] = bytes[i];
  return frame;
}

}  // namespace j1939
