#include "daemon/status/bus_events.h"

#include <fmt/format.h>

#include <utility>

#include "can/adapter/link_remedy.h"
#include "can/bus_names.h"
#include "daemon/bus/adapter_text.h"
#include "daemon_config/bit_timing_check.h"

namespace cansyncd {
namespace {

EventText event(gateway_EventSeverity severity, EventCode code, std::string text) {
  return {severity, code, -1, std::move(text), std::nullopt};
}

gateway_EventSeverity severity_of(can::ControllerState state) {
  switch (state) {
    case can::ControllerState::bus_off:
    case can::ControllerState::stopped:
      return gateway_SEVERITY_ERROR;
    case can::ControllerState::error_passive:
    case can::ControllerState::error_warning:
      return gateway_SEVERITY_WARNING;
    case can::ControllerState::error_active:
      break;
  }
  return gateway_SEVERITY_INFO;
}

EventText delivery_event(can::Delivery to, const BusConfig& bus) {
  switch (to) {
    case can::Delivery::normal:
      return event(gateway_SEVERITY_INFO, "delivered_again", "frames are on the bus again");
    case can::Delivery::unacknowledged:
      return event(gateway_SEVERITY_ERROR, "not_delivered",
                   fmt::format("nobody on the bus of {} acknowledges; check the cable, both terminating "
                               "resistors, and the power and bit rate of the other nodes",
                               bus.interface));
    case can::Delivery::not_emptied:
      break;
  }
  return event(
      gateway_SEVERITY_ERROR, "not_emptied",
      fmt::format("{0} could not be reset: what was handed over before nobody acknowledged stands in its "
                  "controller and goes out when somebody does; empty it as root: ip link set {0} down "
                  "&& ip link set {0} up",
                  bus.interface));
}

}  // namespace

EventText link_event(const can::ControllerStatus& to, const BusConfig& bus, const can::LinkFacts& link) {
  switch (to.link) {
    case can::LinkState::up:
      return event(gateway_SEVERITY_INFO, "interface_up", fmt::format("{} is up again", bus.interface));
    case can::LinkState::missing:
      return event(
          gateway_SEVERITY_ERROR, "interface_missing",
          fmt::format("there is no CAN interface {}, nothing is sent; plug the adapter in, or load its "
                      "driver",
                      bus.interface));
    case can::LinkState::wrong_adapter:
      return event(gateway_SEVERITY_ERROR, "wrong_adapter", wrong_adapter_text(bus, link));
    case can::LinkState::wrong_bit_rate:
      return event(
          gateway_SEVERITY_ERROR, "wrong_bit_rate",
          fmt::format("{} is set to {} bit/s instead of {}, nothing is sent; set it with: {}", bus.interface,
                      to.bits_per_second, bus.bits_per_second, bit_rate_command(bus, link)));
    case can::LinkState::not_one_shot:
      return event(
          gateway_SEVERITY_ERROR, "not_one_shot",
          fmt::format("{} is not in one-shot mode, which bus.one_shot demands, nothing is sent; set it "
                      "with: {}",
                      bus.interface, one_shot_command(bus)));
    case can::LinkState::listen_only:
      return event(
          gateway_SEVERITY_WARNING, "listen_only",
          fmt::format("{} is in listen-only mode: frames are received, nothing is sent; to send, set it "
                      "with: {}",
                      bus.interface, can::sending_remedy(bus.interface)));
    case can::LinkState::down:
      break;
  }
  return event(gateway_SEVERITY_ERROR, "interface_down",
               fmt::format("{} is down, nothing is sent; set it up with: {}", bus.interface,
                           set_up_command(bus, link)));
}

std::vector<EventText> bus_events(const can::ControllerStatus& from, const can::ControllerStatus& to,
                                  const BusConfig& bus, const can::LinkFacts& link) {
  std::vector<EventText> events;
  if (from.link != to.link) events.push_back(link_event(to, bus, link));
  if (from.delivery != to.delivery) events.push_back(delivery_event(to.delivery, bus));
  if (from.state != to.state) {
    events.push_back(event(severity_of(to.state), "controller_changed",
                           fmt::format("controller: {} -> {}", can::name(from.state), can::name(to.state))));
  }
  return events;
}

}  // namespace cansyncd
