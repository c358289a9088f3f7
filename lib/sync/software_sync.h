#pragma once

#include <cstdint>

#include "can/bus.h"
#include "can/frame.h"
#include "can/frame_length.h"
#include "sync/phase_lock.h"

/// The software SYNC frame: an extension for buses without the SYNC wires, not part of CANsync. A standard
/// frame without data bytes, handed to the bus at the SYNC edge. Pure functions; realtime safe.
namespace sync_line {

/// The frame of an identifier.
inline can::Frame software_sync(std::uint32_t identifier) noexcept {
  can::Frame frame;
  frame.id = identifier;
  return frame;
}

/// Is `frame` the software SYNC of that identifier?
inline bool is_software_sync(const can::Frame& frame, std::uint32_t identifier) noexcept {
  return frame.is_standard_data() && frame.id == identifier && frame.dlc == 0;
}

/// The SYNC edge a received frame stands for: the instant its first bit was sent.
inline Time edge_of(const can::ReceivedFrame& received, std::uint32_t bits_per_second) noexcept {
  constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;
  const std::int64_t bits = can::frame_bits(received.frame) - can::kInterframeBits;
  return received.end - Time(bits * kNanosecondsPerSecond / bits_per_second);
}

}  // namespace sync_line
