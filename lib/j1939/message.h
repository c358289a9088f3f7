#pragma once

#include <cstdint>
#include <span>

#include "j1939/identifier.h"

namespace j1939 {

/// How a message came over the bus.
enum class Transport : std::uint8_t {
  frame,       ///< one frame, up to 8 bytes
  broadcast,   ///< packets for all (BAM)
  connection,  ///< packets for one, each window asked for (RTS and CTS)
  extended,    ///< likewise, by the extended transport protocol
};

/// A whole message.
struct Message {
  Pgn number = 0;             ///< its group
  std::uint8_t priority = 6;  ///< 0..7; of packets that of the announcement
  Address source = 0;         ///< 0..254
  Address destination = 0;    ///< 0..255, kGlobalAddress: all
  Transport transport = Transport::frame;
  Time end{};                          ///< end of its last frame
  std::span<const std::uint8_t> data;  ///< stays as long as the function that gave it says
};

}  // namespace j1939
