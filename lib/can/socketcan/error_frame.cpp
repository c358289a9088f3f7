#include "can/socketcan/error_frame.h"

#include <linux/can/error.h>

namespace can {
namespace {

/// Byte 1 of an error frame of class CAN_ERR_CRTL: the worst state it names.
std::optional<ControllerState> state_in(std::uint8_t controller) noexcept {
  if ((controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
    return ControllerState::error_passive;
  }
  if ((controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0) {
    return ControllerState::error_warning;
  }
  if ((controller & CAN_ERR_CRTL_ACTIVE) != 0) return ControllerState::error_active;
  return std::nullopt;
}

}  // namespace

ErrorFrame read_error_frame(const can_frame& frame) noexcept {
  ErrorFrame error;
  const auto has = [&frame](canid_t kind) { return (frame.can_id & kind) != 0; };
  if (has(CAN_ERR_CRTL)) {
    error.state = state_in(frame.data[1]);
    error.overrun = (frame.data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
  }
  if (has(CAN_ERR_RESTARTED)) {
    error.restarted = true;
    error.state = ControllerState::error_active;
  }
  if (has(CAN_ERR_BUSOFF)) error.state = ControllerState::bus_off;
  // Some drivers name the bit of the frame in which the error was, instead of the class.
  error.not_acknowledged = has(CAN_ERR_ACK) || (has(CAN_ERR_PROT) && frame.data[3] == CAN_ERR_PROT_LOC_ACK);
  if (has(CAN_ERR_CNT)) error.counters = ErrorFrame::Counters{frame.data[6], frame.data[7]};
  return error;
}

}  // namespace can
