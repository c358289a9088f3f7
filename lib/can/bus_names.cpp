#include "can/bus_names.h"

namespace can {

std::string_view name(ControllerState state) noexcept {
  switch (state) {
    case ControllerState::error_active:
      return "error-active";
    case ControllerState::error_warning:
      return "error-warning";
    case ControllerState::error_passive:
      return "error-passive";
    case ControllerState::bus_off:
      return "bus-off";
    case ControllerState::stopped:
      return "stopped";
  }
  return "unknown";
}

std::string_view name(LinkState state) noexcept {
  switch (state) {
    case LinkState::up:
      return "up";
    case LinkState::down:
      return "down";
    case LinkState::missing:
      return "missing";
    case LinkState::wrong_adapter:
      return "wrong-adapter";
    case LinkState::wrong_bit_rate:
      return "wrong-bit-rate";
    case LinkState::not_one_shot:
      return "not-one-shot";
    case LinkState::listen_only:
      return "listen-only";
  }
  return "unknown";
}

std::string_view name(Delivery delivery) noexcept {
  switch (delivery) {
    case Delivery::normal:
      return "normal";
    case Delivery::unacknowledged:
      return "unacknowledged";
    case Delivery::not_emptied:
      return "not-emptied";
  }
  return "unknown";
}

std::string_view name(TimestampSource source) noexcept {
  switch (source) {
    case TimestampSource::simulation:
      return "simulation";
    case TimestampSource::hardware:
      return "hardware";
    case TimestampSource::kernel:
      return "kernel";
    case TimestampSource::thread:
      return "thread";
  }
  return "unknown";
}

}  // namespace can
