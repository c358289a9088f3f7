#include "daemon/status/status_line.h"

#include <fmt/format.h>

namespace cansyncd {

std::string bus_problem(const can::ControllerStatus& controller, const BusConfig& bus) {
  const std::string& interface = bus.interface;
  switch (controller.link) {
    case can::LinkState::up:
      break;
    case can::LinkState::missing:
      return fmt::format("waiting for interface {}: it is missing", interface);
    case can::LinkState::down:
      return fmt::format("waiting for interface {}: it is down", interface);
    case can::LinkState::wrong_adapter:
      return fmt::format("nothing is sent: interface {} has another adapter than bus.adapter", interface);
    case can::LinkState::wrong_bit_rate:
      return fmt::format("nothing is sent: interface {} has another bit rate than the configured one",
                         interface);
    case can::LinkState::not_one_shot:
      return fmt::format("nothing is sent: interface {} is not in one-shot mode", interface);
    case can::LinkState::listen_only:
      return fmt::format("nothing is sent: interface {} is in listen-only mode", interface);
  }
  if (controller.delivery != can::Delivery::normal) {
    return fmt::format(
        "nobody on the bus of interface {} acknowledges: check cable, terminating resistors and the power of "
        "the other nodes",
        interface);
  }
  if (controller.state == can::ControllerState::bus_off)
    return fmt::format("nothing is sent: the controller of {} is bus-off", interface);
  return {};
}

std::string bus_sentence(const std::string& state, const can::ControllerStatus& controller,
                         const BusConfig& bus) {
  std::string problem = bus_problem(controller, bus);
  if (!problem.empty()) return problem;
  return fmt::format("{}; bus {} ({}) at {} bit/s", state, bus.name, bus.interface, bus.bits_per_second);
}

}  // namespace cansyncd
