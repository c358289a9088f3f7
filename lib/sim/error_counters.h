#pragma once

#include <algorithm>
#include <cstdint>

#include "can/bus.h"

namespace sim {

/// Fault confinement of one node after CAN 2.0: what a transmission error costs, and what it leads to.
/// Realtime safe.
class ErrorCounters {
 public:
  static constexpr std::uint16_t kWarning = 96;
  static constexpr std::uint16_t kPassive = 128;
  static constexpr std::uint16_t kBusOff = 256;

  /// This node's own frame was destroyed.
  void transmit_failed() noexcept { transmit_ = std::min<std::uint16_t>(transmit_ + 8, kBusOff); }
  /// Another node's frame was destroyed.
  void receive_failed() noexcept { receive_ = std::min<std::uint16_t>(receive_ + 1, 255); }
  /// This node's own frame went well.
  void transmitted() noexcept {
    if (transmit_ > 0 && transmit_ < kBusOff) --transmit_;
  }
  /// Another node's frame went well.
  void received() noexcept {
    if (receive_ >= kPassive) {
      receive_ = kPassive - 1;
    } else if (receive_ > 0) {
      --receive_;
    }
  }
  void clear() noexcept { transmit_ = receive_ = 0; }

  bool clean() const noexcept { return transmit_ == 0 && receive_ == 0; }
  bool bus_off() const noexcept { return transmit_ >= kBusOff; }
  std::uint16_t transmit_errors() const noexcept { return transmit_; }
  std::uint16_t receive_errors() const noexcept { return receive_; }

  can::ControllerState state() const noexcept {
    const std::uint16_t most = std::max(transmit_, receive_);
    if (bus_off()) return can::ControllerState::bus_off;
    if (most >= kPassive) return can::ControllerState::error_passive;
    if (most >= kWarning) return can::ControllerState::error_warning;
    return can::ControllerState::error_active;
  }

 private:
  std::uint16_t transmit_ = 0;
  std::uint16_t receive_ = 0;
};

}  // namespace sim
