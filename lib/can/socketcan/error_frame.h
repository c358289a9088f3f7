#pragma once

#include <linux/can.h>

#include <cstdint>
#include <optional>

#include "can/bus.h"

namespace can {

/// What the kernel tells in one error frame (linux/can/error.h). Several things can stand in one.
struct ErrorFrame {
  std::optional<ControllerState> state;  ///< the controller went into this state
  bool restarted = false;                ///< it left bus-off
  bool not_acknowledged = false;         ///< a frame of ours was acknowledged by nobody
  bool overrun = false;                  ///< the controller lost a received frame
  /// Both error counters, when the driver gives them; each 0..255.
  struct Counters {
    std::uint8_t transmit = 0;
    std::uint8_t receive = 0;
  };
  std::optional<Counters> counters;
};

/// Reads an error frame, one whose `can_id` has CAN_ERR_FLAG set. Pure; realtime safe. Unknown classes tell
/// nothing.
ErrorFrame read_error_frame(const can_frame& frame) noexcept;

}  // namespace can
