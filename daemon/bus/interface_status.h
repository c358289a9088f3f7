#pragma once

#include <cstdint>

#include "can/bus.h"

namespace cansyncd {

/// What the interface status register is made of, beside the controller's state.
struct InterfaceFacts {
  bool lost_frames = false;   ///< received frames were lost in the running second
  bool heard_others = false;  ///< a frame of somebody else came in this interval
  bool echo_due = false;      ///< the last own telegram was not seen on the bus yet
  can::SendResult last_send = can::SendResult::queued;
};

/// Interface status register w_CANsync_STATUS (M 3.2.2.2, 3.2.3.2): bit 1 overrun, 2 send buffer free, 3 last
/// telegram was sent, 4 receiving, 5 sending, 6 warning limit, 7 bus-off. Realtime safe.
constexpr std::uint16_t interface_status(const InterfaceFacts& facts, can::ControllerState state) noexcept {
  using can::ControllerState;
  const bool warning = state == ControllerState::error_warning || state == ControllerState::error_passive;
  unsigned bits = 0;
  if (facts.lost_frames) bits |= 1u << 1;
  if (facts.last_send != can::SendResult::queue_full) bits |= 1u << 2;
  if (!facts.echo_due && facts.last_send == can::SendResult::queued) bits |= 1u << 3;
  if (facts.heard_others) bits |= 1u << 4;
  if (facts.echo_due) bits |= 1u << 5;
  if (warning) bits |= 1u << 6;
  if (state == ControllerState::bus_off) bits |= 1u << 7;
  return static_cast<std::uint16_t>(bits);
}

}  // namespace cansyncd
