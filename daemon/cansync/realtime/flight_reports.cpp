#include "daemon/cansync/realtime/flight_reports.h"

#include <array>
#include <string_view>
#include <variant>

#include "cansync/settings/mode.h"

namespace cansyncd {
namespace {

void tell_event(FlightTap& tap, const EventReport& report) noexcept {
  using Code = cansync::MasterEvent::Code;
  if (report.event.code == Code::slave_lost) {
    tap.fault(FlightReason::slave_lost, report.event.slave ? report.event.slave->value() : 0U, report.when);
  } else if (report.event.code == Code::second_master) {
    tap.fault(FlightReason::second_master, report.event.detail, report.when);
  }
}

std::string_view slot_name(std::uint32_t slot) noexcept {
  constexpr std::array<std::string_view, cansync::kSlots> kNames = {"WRC1", "WRC2", "CC"};
  return slot < kNames.size() ? kNames[slot] : "unknown";
}

std::string_view state_name(std::uint32_t state) noexcept {
  return cansync::name(static_cast<cansync::State>(state));
}

}  // namespace

void tell(FlightTap& tap, const Report& report) noexcept {
  const auto not_sent = [&tap](can::SendResult result, const Moment& when) {
    tap.fault(FlightReason::sending_failed, static_cast<std::uint64_t>(result), when);
  };
  if (const auto* state = std::get_if<StateChanged>(&report)) {
    tap.state(state->when, static_cast<std::uint32_t>(state->to));
  } else if (const auto* controller = std::get_if<ControllerChanged>(&report)) {
    tap.controller(controller->when, controller->to);
  } else if (const auto* missed = std::get_if<SyncsMissed>(&report)) {
    tap.fault(FlightReason::syncs_missed, missed->count, missed->when);
  } else if (const auto* sending = std::get_if<SendingChanged>(&report)) {
    if (sending->result != can::SendResult::queued) not_sent(sending->result, sending->when);
  } else if (const auto* link = std::get_if<LinkChanged>(&report)) {
    if (link->to != can::LinkState::up) not_sent(can::SendResult::interface_down, link->when);
  } else if (const auto* delivery = std::get_if<DeliveryChanged>(&report)) {
    if (delivery->from == can::Delivery::normal) not_sent(can::SendResult::not_delivered, delivery->when);
  } else if (const auto* event = std::get_if<EventReport>(&report)) {
    tell_event(tap, *event);
  }
}

FlightProtocol flight_protocol(can::Time interval) noexcept {
  return {interval, slot_name, state_name};
}

}  // namespace cansyncd
