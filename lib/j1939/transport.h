#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "j1939/identifier.h"

/// What both ends of the transport protocol and of its extended form (SAE J1939-21) share.
namespace j1939 {

/// Most bytes of a message by the transport protocol.
inline constexpr std::size_t kMostBytes = 1785;
/// Most bytes of a message by the extended transport protocol; a node takes as many as it is told to.
inline constexpr std::size_t kMostExtendedBytes = 117'440'505;
/// Data bytes of one packet.
inline constexpr std::size_t kPacketBytes = 7;

/// Time-outs; the letters are those of the standard.
inline constexpr Time kT1 = std::chrono::milliseconds(750);   ///< receiver: between two packets
inline constexpr Time kT2 = std::chrono::milliseconds(1250);  ///< receiver: from its CTS to a packet
inline constexpr Time kT3 = std::chrono::milliseconds(1250);  ///< sender: to CTS or the acknowledgement
inline constexpr Time kT4 = std::chrono::milliseconds(1050);  ///< sender: held, to the next CTS
/// Most times a packet is asked for again, and those that follow it in its window.
inline constexpr unsigned kMostRepeats = 2;

/// Why a connection was broken off (control byte 255).
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

/// First byte of a connection management message.
enum class Control : std::uint8_t {
  rts = 16,
  cts = 17,
  acknowledged = 19,
  bam = 32,
  abort = 255,
  // Of the extended form.
  extended_rts = 20,
  extended_cts = 21,
  extended_offset = 22,  ///< of the packets that follow
  extended_acknowledged = 23,
};

/// Packets that so many bytes need: 0..255, of the extended form up to 16,777,215.
constexpr std::uint32_t packets_of(std::size_t bytes) noexcept {
  return static_cast<std::uint32_t>((bytes + kPacketBytes - 1) / kPacketBytes);
}

/// A number in three or four bytes of a connection management message, the lowest first.
constexpr std::uint32_t number_in(const can::Frame& frame, std::size_t at, std::size_t bytes) noexcept {
  std::uint32_t number = 0;
  for (std::size_t i = bytes; i-- > 0;) number = number << 8 | frame.data[at + i];
  return number;
}

/// Likewise, to be sent: byte `at` of a number.
constexpr std::uint8_t byte_of(std::uint32_t number, unsigned at) noexcept {
  return static_cast<std::uint8_t>(number >> 8 * at);
}

/// The group that a connection management message speaks of: its last three bytes.
constexpr Pgn pgn_in(const can::Frame& frame) noexcept {
  return (Pgn{frame.data[5]} | Pgn{frame.data[6]} << 8 | Pgn{frame.data[7]} << 16) & 0xFFFFFF;
}

/// A connection management message: five bytes and the group.
constexpr can::Frame control_frame(Address source, Address destination, Pgn number, Control control,
                                   const std::array<std::uint8_t, 4>& bytes,
                                   Pgn by = pgn::kTransportControl) noexcept {
  return frame_of(
      identifier_of(by, 7, destination, source),
      std::array<std::uint8_t, 8>{static_cast<std::uint8_t>(control), bytes[0], bytes[1], bytes[2], bytes[3],
                                  static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8),
                                  static_cast<std::uint8_t>(number >> 16)});
}

/// Breaks a connection off.
constexpr can::Frame abort_frame(Address source, Address destination, Pgn number, AbortReason reason,
                                 Pgn by = pgn::kTransportControl) noexcept {
  return control_frame(source, destination, number, Control::abort,
                       {static_cast<std::uint8_t>(reason), 0xFF, 0xFF, 0xFF}, by);
}

/// Short frames that wait to be sent, oldest first; one that finds no room is lost, and counted.
class FrameQueue {
 public:
  static constexpr std::size_t kMost = 32;

  /// Appends a frame, or counts it as lost.
  void push(const can::Frame& frame) noexcept {
    if (size_ == kMost) {
      ++lost_;
      return;
    }
    frames_[(first_ + size_++) % kMost] = frame;
  }
  /// The oldest; nothing: none waits.
  std::optional<can::Frame> front() const noexcept {
    return size_ == 0 ? std::nullopt : std::optional(frames_[first_]);
  }
  /// One with this identifier waits.
  bool has(std::uint32_t id) const noexcept {
    for (std::size_t i = 0; i < size_; ++i)
      if (frames_[(first_ + i) % kMost].id == id) return true;
    return false;
  }
  /// Takes the oldest away; there must be one.
  void pop() noexcept {
    first_ = (first_ + 1) % kMost;
    --size_;
  }
  /// Takes all away.
  void clear() noexcept { size_ = 0; }
  /// Frames for which there was no room.
  std::uint64_t lost() const noexcept { return lost_; }

 private:
  std::array<can::Frame, kMost> frames_ = {};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::uint64_t lost_ = 0;
};

}  // namespace j1939
