#include "j1939/codec.h"

#include <algorithm>

namespace j1939 {
namespace {

/// First byte of a connection management message.
enum class Control : std::uint8_t {
  request_to_send = 16,
  clear_to_send = 17,
  end_of_message = 19,
  extended_request_to_send = 20,
  extended_clear_to_send = 21,
  extended_data_offset = 22,
  extended_end_of_message = 23,
  announcement = 32,
  abort = 255,
};

/// Bytes 1 to 4 of a connection management message.
using Said = std::array<std::uint8_t, 4>;

/// A number in bytes, the lowest first.
constexpr std::uint32_t number_in(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t number = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) number = number << 8 | bytes[i];
  return number;
}

/// Byte `at` of a number.
constexpr std::uint8_t byte_of(std::uint32_t number, unsigned at) noexcept {
  return static_cast<std::uint8_t>(number >> 8 * at);
}

constexpr Said size_and_packets(std::uint32_t size, std::uint32_t packets, std::uint8_t last) noexcept {
  return {byte_of(size, 0), byte_of(size, 1), byte_of(packets, 0), last};
}

constexpr Said number_of_four(std::uint32_t number) noexcept {
  return {byte_of(number, 0), byte_of(number, 1), byte_of(number, 2), byte_of(number, 3)};
}

constexpr Said count_and_number(std::uint8_t count, std::uint32_t number) noexcept {
  return {count, byte_of(number, 0), byte_of(number, 1), byte_of(number, 2)};
}

/// First byte and the four behind it.
struct Bytes {
  Control control;
  Said said;
};

Bytes bytes_of(const TransportControl& control) noexcept {
  const bool extended = control.extended;
  if (const auto* rts = std::get_if<RequestToSend>(&control.what)) {
    if (extended) return {Control::extended_request_to_send, number_of_four(rts->size)};
    return {Control::request_to_send, size_and_packets(rts->size, rts->packets, rts->most)};
  }
  if (const auto* cts = std::get_if<ClearToSend>(&control.what)) {
    if (extended) return {Control::extended_clear_to_send, count_and_number(cts->count, cts->first)};
    return {Control::clear_to_send, {cts->count, byte_of(cts->first, 0), 0xFF, 0xFF}};
  }
  if (const auto* offset = std::get_if<DataOffset>(&control.what))
    return {Control::extended_data_offset, count_and_number(offset->count, offset->offset)};
  if (const auto* end = std::get_if<EndOfMessage>(&control.what)) {
    if (extended) return {Control::extended_end_of_message, number_of_four(end->size)};
    return {Control::end_of_message, size_and_packets(end->size, end->packets, 0xFF)};
  }
  if (const auto* bam = std::get_if<Announcement>(&control.what))
    return {Control::announcement, size_and_packets(bam->size, bam->packets, 0xFF)};
  const auto* abort = std::get_if<Abort>(&control.what);
  return {Control::abort, {static_cast<std::uint8_t>(abort->reason), 0xFF, 0xFF, 0xFF}};
}

/// What a connection management message of the transport protocol says.
std::optional<TransportControl::What> plain_in(std::span<const std::uint8_t, 8> bytes) noexcept {
  const std::uint32_t size = number_in(bytes.subspan<1, 2>());
  switch (static_cast<Control>(bytes[0])) {
    case Control::request_to_send:
      return RequestToSend{size, bytes[3], bytes[4]};
    case Control::clear_to_send:
      return ClearToSend{bytes[1], bytes[2]};
    case Control::end_of_message:
      return EndOfMessage{size, bytes[3]};
    case Control::announcement:
      return Announcement{size, bytes[3]};
    case Control::abort:
      return Abort{static_cast<AbortReason>(bytes[1])};
    default:
      return std::nullopt;
  }
}

/// Likewise of its extended form.
std::optional<TransportControl::What> extended_in(std::span<const std::uint8_t, 8> bytes) noexcept {
  switch (static_cast<Control>(bytes[0])) {
    case Control::extended_request_to_send:
      return RequestToSend{number_in(bytes.subspan<1, 4>())};
    case Control::extended_clear_to_send:
      return ClearToSend{bytes[1], number_in(bytes.subspan<2, 3>())};
    case Control::extended_data_offset:
      return DataOffset{bytes[1], number_in(bytes.subspan<2, 3>())};
    case Control::extended_end_of_message:
      return EndOfMessage{number_in(bytes.subspan<1, 4>())};
    case Control::abort:
      return Abort{static_cast<AbortReason>(bytes[1])};
    default:
      return std::nullopt;
  }
}

}  // namespace

std::optional<TransportControl> transport_control_in(const can::Frame& frame) noexcept {
  if (frame.dlc != 8) return std::nullopt;
  const std::span<const std::uint8_t, 8> bytes(frame.data);
  const bool extended = pgn_of(parse(frame.id)) == pgn::kExtendedTransportControl;
  const auto what = extended ? extended_in(bytes) : plain_in(bytes);
  if (!what) return std::nullopt;
  return TransportControl{extended, number_in(bytes.last<3>()), *what};
}

can::Frame frame_of(const TransportControl& said, Address source, Address destination,
                    std::uint8_t priority) noexcept {
  const Bytes bytes = bytes_of(said);
  const Pgn by = said.extended ? pgn::kExtendedTransportControl : pgn::kTransportControl;
  return frame_of(
      identifier_of(by, priority, destination, source),
      std::array{static_cast<std::uint8_t>(bytes.control), bytes.said[0], bytes.said[1], bytes.said[2],
                 bytes.said[3], byte_of(said.number, 0), byte_of(said.number, 1), byte_of(said.number, 2)});
}

std::optional<Packet> packet_in(const can::Frame& frame) noexcept {
  if (frame.dlc != 8) return std::nullopt;
  const std::span<const std::uint8_t> bytes(frame.data);
  return Packet{bytes[0], bytes.subspan(1)};
}

can::Frame frame_of(const Packet& packet, bool extended, Address source, Address destination,
                    std::uint8_t priority) noexcept {
  std::array<std::uint8_t, 8> bytes;
  bytes.fill(0xFF);
  bytes[0] = packet.number;
  std::copy_n(packet.data.begin(), std::min(packet.data.size(), kPacketBytes), bytes.begin() + 1);
  const Pgn by = extended ? pgn::kExtendedTransportData : pgn::kTransportData;
  return frame_of(identifier_of(by, priority, destination, source), bytes);
}

std::optional<Acknowledgement> acknowledgement_in(std::span<const std::uint8_t> data) noexcept {
  constexpr auto kLast = static_cast<std::uint8_t>(Acknowledgement::Kind::cannot_respond);
  if (data.size() != 8 || data[0] > kLast) return std::nullopt;
  return Acknowledgement{static_cast<Acknowledgement::Kind>(data[0]), data[4], number_in(data.last(3))};
}

can::Frame frame_of(const Acknowledgement& said, Address source) noexcept {
  return frame_of(
      identifier_of(pgn::kAcknowledgement, 6, kGlobalAddress, source),
      std::array<std::uint8_t, 8>{static_cast<std::uint8_t>(said.kind), 0xFF, 0xFF, 0xFF, said.whose,
                                  byte_of(said.number, 0), byte_of(said.number, 1), byte_of(said.number, 2)});
}

std::optional<Pgn> requested_in(std::span<const std::uint8_t> data) noexcept {
  return data.size() < 3 ? std::nullopt : std::optional(number_in(data.first(3)));
}

can::Frame request_frame(Pgn number, Address source, Address destination, std::uint8_t priority) noexcept {
  return frame_of(identifier_of(pgn::kRequest, priority, destination, source),
                  std::array{byte_of(number, 0), byte_of(number, 1), byte_of(number, 2)});
}

std::optional<CommandedAddress> commanded_address_in(std::span<const std::uint8_t> data) noexcept {
  if (data.size() != 9) return std::nullopt;
  return CommandedAddress{name_of(data), data[8]};
}

std::optional<Name> claimed_name_in(std::span<const std::uint8_t> data) noexcept {
  return data.size() == 8 ? std::optional(name_of(data)) : std::nullopt;
}

can::Frame claim_frame(Name name, Address address) noexcept {
  std::array<std::uint8_t, 8> bytes = {};
  for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(name >> 8 * i);
  return frame_of(identifier_of(pgn::kAddressClaimed, 6, kGlobalAddress, address), bytes);
}

}  // namespace j1939
