#include "daemon/cansync/texts/bus_text.h"

#include <fmt/format.h>

#include "cansync/dds/convert.h"
#include "daemon/status/bus_events.h"
#include "daemon_config/bit_timing_check.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

struct FaultWords {
  EventCode begun;
  EventCode over;
  std::string_view what;
  std::string_view remedy;
};

FaultWords words_of(BusFaultKind kind) {
  switch (kind) {
    case BusFaultKind::not_acknowledged:
      return {"not_acknowledged", "acknowledged", "telegrams are acknowledged by nobody",
              "is another node on the bus, switched on, with the same bit rate?"};
    case BusFaultKind::error_frames:
      return {"bus_errors", "bus_errors_over", "there are error frames on the bus",
              "check bit rate, cable and both terminating resistors"};
    case BusFaultKind::overrun:
      return {"controller_overrun", "controller_overrun_over", "the controller loses received frames",
              "the machine serves its interrupt too late"};
    case BusFaultKind::dropped:
      return {"frames_dropped", "frames_dropped_over", "received frames are lost before they are taken",
              "the realtime thread comes too late: give it a realtime priority and a processor of its own"};
  }
  return {"bus_fault", "bus_fault_over", "unknown fault", ""};
}

}  // namespace

EventText describe_link(const LinkChanged& report, const Config& config, const can::LinkFacts& link) {
  EventText event =
      link_event({.link = report.to, .bits_per_second = report.bits_per_second}, config.bus, link);
  if (report.to == can::LinkState::up)
    event.text +=
        fmt::format("; {} left out", text::counted(report.left_out, "telegram was", "telegrams were"));
  // A line stands still without its master.
  if (report.to == can::LinkState::listen_only) event.severity = gateway_SEVERITY_ERROR;
  event.when = report.when;
  return event;
}

EventText describe_fault(const BusFault& report) {
  const FaultWords words = words_of(report.kind);
  if (report.over) {
    return {gateway_SEVERITY_INFO, words.over, -1,
            fmt::format("no longer: {}; it happened {}", words.what, text::counted(report.count, "time")),
            report.when};
  }
  return {gateway_SEVERITY_WARNING, words.begun, -1, fmt::format("{}; {}", words.what, words.remedy),
          report.when};
}

EventText describe_delivery(const DeliveryChanged& report, const Config& config) {
  const std::string& interface = config.bus.interface;
  switch (report.to) {
    case can::Delivery::normal:
      return {gateway_SEVERITY_INFO, "delivered_again", -1,
              fmt::format("telegrams are on the bus again; {} were handed over in vain, {} were left out",
                          report.never_sent, report.left_out),
              report.when};
    case can::Delivery::unacknowledged:
      return {
          gateway_SEVERITY_ERROR, "not_delivered", -1,
          fmt::format("nobody on the bus of {} acknowledges: no telegram was on it for two intervals; check "
                      "the cable, both terminating resistors, the power and the bit rate of the drives",
                      interface),
          report.when};
    case can::Delivery::not_emptied:
      break;
  }
  return {
      gateway_SEVERITY_ERROR, "not_emptied", -1,
      fmt::format("{0} could not be reset: what was handed over before nobody acknowledged stands in its "
                  "controller and goes out when somebody does, and nothing else is sent before; empty it as "
                  "root: ip link set {0} down && ip link set {0} up; for the next time: one-shot mode ({1}), "
                  "or CAP_NET_ADMIN for the daemon",
                  interface, one_shot_command(config.bus)),
      report.when};
}

std::string reset_not_permitted(const Config& config) {
  return fmt::format(
      "mode: the daemon may not reset {0} (it has not got CAP_NET_ADMIN); out of bus-off, give as root: ip "
      "link set {0} type can restart; or let the kernel do it: while it is down, ip link set {0} type can "
      "restart-ms 100",
      config.bus.interface);
}

std::string reset_unavailable(const Config& config) {
  return fmt::format(
      "mode: {0} is missing or down, or its driver cannot be reset; look at it with: ip -details link show "
      "{0}",
      config.bus.interface);
}

}  // namespace cansyncd
