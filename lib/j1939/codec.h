#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "can/frame.h"
#include "j1939/identifier.h"
#include "j1939/name.h"

/// What data link and network management say, as fields and as bytes (SAE J1939-21, -81). Realtime safe; any thread.
namespace j1939 {

/// Asks for a connection (RTS).
struct RequestToSend {
  std::uint32_t size = 0;     ///< bytes of the message
  std::uint32_t packets = 0;  ///< that it needs; the extended form does not say it
  std::uint8_t most =
      255;  ///< packets of one window; 0 and 255: as many as the receiver wants; not of the extended form

  friend bool operator==(const RequestToSend&, const RequestToSend&) = default;
};

/// Asks for packets (CTS).
struct ClearToSend {
  std::uint8_t count = 0;   ///< 0: the connection is held
  std::uint32_t first = 0;  ///< number of the first packet, from 1 on

  friend bool operator==(const ClearToSend&, const ClearToSend&) = default;
};

/// Says which packets follow; the extended form alone has it (DPO).
struct DataOffset {
  std::uint8_t count = 0;    ///< packets
  std::uint32_t offset = 0;  ///< what their numbers count from

  friend bool operator==(const DataOffset&, const DataOffset&) = default;
};

/// The whole message has come (EOMA).
struct EndOfMessage {
  std::uint32_t size = 0;     ///< bytes of the message
  std::uint32_t packets = 0;  ///< of it; the extended form does not say it

  friend bool operator==(const EndOfMessage&, const EndOfMessage&) = default;
};

/// Announces packets for all (BAM); the extended form has none.
struct Announcement {
  std::uint32_t size = 0;     ///< bytes of the message
  std::uint32_t packets = 0;  ///< that it needs

  friend bool operator==(const Announcement&, const Announcement&) = default;
};

/// Why a connection was broken off.
enum class AbortReason : std::uint8_t {
  busy = 1,               ///< has a connection with this node already
  no_resources = 2,       ///< its resources are needed elsewhere
  timeout = 3,            ///< the other did not go on in time
  cts_while_sending = 4,  ///< clear to send in the midst of packets
  too_many_repeats = 5,   ///< more packets asked for again than are given
  unexpected_data = 6,    ///< a packet outside the window
  bad_sequence = 7,       ///< a packet's number that cannot be
  twice = 8,              ///< a packet twice
  too_long = 9,           ///< more than 1785 bytes
  // Of the extended form alone.
  wrong_count = 11,   ///< its offset announces more packets than were asked for
  wrong_offset = 12,  ///< its offset is not that of the packet that was asked for
};

/// Breaks a connection off.
struct Abort {
  AbortReason reason = AbortReason::no_resources;  ///< or another number

  friend bool operator==(const Abort&, const Abort&) = default;
};

/// A connection management message, of the transport protocol or of its extended form.
struct TransportControl {
  using What = std::variant<RequestToSend, ClearToSend, DataOffset, EndOfMessage, Announcement, Abort>;

  bool extended = false;
  Pgn number = 0;  ///< the group that it speaks of; 24 bits, as they came
  What what;

  friend bool operator==(const TransportControl&, const TransportControl&) = default;
};

/// Of a frame of the group kTransportControl or kExtendedTransportControl. Nothing: it has not 8 bytes, or a first byte that
/// its form does not know.
std::optional<TransportControl> transport_control_in(const can::Frame& frame) noexcept;

/// `said` by `source`; `priority` 0..7.
can::Frame frame_of(const TransportControl& said, Address source, Address destination,
                    std::uint8_t priority = 7) noexcept;

/// Data bytes of one packet.
inline constexpr std::size_t kPacketBytes = 7;

/// A packet of a message, of either form.
struct Packet {
  std::uint8_t number = 0;  ///< 1..255; of the extended form counted from the offset
  std::span<const std::uint8_t>
      data;  ///< up to kPacketBytes of the message; lives as long as what it was read from
};

/// Of a frame of the group kTransportData or kExtendedTransportData; nothing: it has not 8 bytes.
std::optional<Packet> packet_in(const can::Frame& frame) noexcept;

/// The rest of a packet's bytes are ones; `priority` 0..7.
can::Frame frame_of(const Packet& packet, bool extended, Address source, Address destination,
                    std::uint8_t priority) noexcept;

/// What a node says of a request (PGN 59392).
struct Acknowledgement {
  /// 0 positive, 1 negative, 2 access denied, 3 cannot respond now.
  enum class Kind : std::uint8_t { positive, negative, denied, cannot_respond };

  Kind kind = Kind::positive;
  Address whose = kGlobalAddress;  ///< who had asked; kGlobalAddress: not said, as by old nodes
  Pgn number = 0;                  ///< the group that was asked for

  friend bool operator==(const Acknowledgement&, const Acknowledgement&) = default;
};

/// Nothing: it has not 8 bytes, or another first byte.
std::optional<Acknowledgement> acknowledgement_in(std::span<const std::uint8_t> data) noexcept;

/// `said` by `source`, to all.
can::Frame frame_of(const Acknowledgement& said, Address source) noexcept;

/// The group that a request (PGN 59904) asks for; nothing: it has fewer than 3 bytes.
std::optional<Pgn> requested_in(std::span<const std::uint8_t> data) noexcept;

/// Asks for a group; `priority` 0..7.
can::Frame request_frame(Pgn number, Address source, Address destination, std::uint8_t priority = 6) noexcept;

/// Commands a node to an address (PGN 65240).
struct CommandedAddress {
  Name name = 0;        ///< of the node
  Address address = 0;  ///< which it is to take

  friend bool operator==(const CommandedAddress&, const CommandedAddress&) = default;
};

/// Nothing: it has not 9 bytes.
std::optional<CommandedAddress> commanded_address_in(std::span<const std::uint8_t> data) noexcept;

/// The NAME of an address claimed (PGN 60928); nothing: it has not 8 bytes.
std::optional<Name> claimed_name_in(std::span<const std::uint8_t> data) noexcept;

/// The claim of `address`; kNullAddress: that none could be claimed.
can::Frame claim_frame(Name name, Address address) noexcept;

}  // namespace j1939
