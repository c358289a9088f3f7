#pragma once

#include <cstdint>
#include <string_view>

namespace can {

/// Why the frame that was to be handed over was not.
enum class Obstacle : std::uint8_t {
  none,            ///< earlier frames
  queue_full,      ///< the controller's queue has no room
  bus_off,         ///< the controller takes no part in the bus
  interface_down,  ///< the interface is missing or not up
  not_delivered,   ///< nobody acknowledges what was handed over before
  window_closed,   ///< requests wait for a time that is theirs, the synchronous window
};

/// Why something was not sent within its monitoring time, and what to do about it; lives as long as the
/// program.
std::string_view reason_not_sent(Obstacle obstacle) noexcept;

}  // namespace can
