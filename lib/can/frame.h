#pragma once

#include <array>
#include <cstdint>

namespace can {

/// What kind of frame stands on the bus. CANsync uses `standard` alone; the others exist to be told apart.
enum class FrameKind : std::uint8_t { standard, extended, remote, error };

/// One CAN frame.
struct Frame {
  std::uint32_t id = 0;                   ///< identifier, 0..0x7FF for a standard frame
  FrameKind kind = FrameKind::standard;   ///< only `standard` carries CANsync
  std::uint8_t dlc = 0;                   ///< number of data bytes, 0..8
  std::array<std::uint8_t, 8> data = {};  ///< bytes beyond `dlc` are zero

  friend bool operator==(const Frame&, const Frame&) = default;
};

}  // namespace can
