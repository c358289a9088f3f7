#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "j1939/codec.h"
#include "j1939/identifier.h"

/// What both ends of the transport protocol and of its extended form (SAE J1939-21) share.
namespace j1939 {

/// Most bytes of a message by the transport protocol.
inline constexpr std::size_t kMostBytes = 1785;
/// Most bytes of a message by the extended transport protocol; a node takes as many as it is told to.
inline constexpr std::size_t kMostExtendedBytes = 117'440'505;

/// Time-outs; the letters are those of the standard.
inline constexpr Time kT1 = std::chrono::milliseconds(750);   ///< receiver: between two packets
inline constexpr Time kT2 = std::chrono::milliseconds(1250);  ///< receiver: from its CTS to a packet
inline constexpr Time kT3 = std::chrono::milliseconds(1250);  ///< sender: to CTS or the acknowledgement
inline constexpr Time kT4 = std::chrono::milliseconds(1050);  ///< sender: held, to the next CTS
/// Most times a packet is asked for again, and those that follow it in its window.
inline constexpr unsigned kMostRepeats = 2;

/// Packets that so many bytes need: 0..255, of the extended form up to 16,777,215.
constexpr std::uint32_t packets_of(std::size_t bytes) noexcept {
  return static_cast<std::uint32_t>((bytes + kPacketBytes - 1) / kPacketBytes);
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
