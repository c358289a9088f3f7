#include "daemon/loop/flight_tap.h"

#include <variant>

namespace cansyncd {

using Kind = rt::FlightEntry::Kind;

const char* name(FlightReason reason) noexcept {
  switch (reason) {
    case FlightReason::requested:
      return "requested";
    case FlightReason::bus_off:
      return "bus_off";
    case FlightReason::syncs_missed:
      return "syncs_missed";
    case FlightReason::slave_lost:
      return "slave_lost";
    case FlightReason::second_master:
      return "second_master";
    case FlightReason::sending_failed:
      return "sending_failed";
  }
  return "unknown";
}

void FlightTap::at(const Moment& moment) noexcept {
  const bool begins = moment.interval != moment_.interval;
  moment_ = moment;
  if (begins) {
    recorder_.begin_interval({static_cast<std::uint32_t>(FlightReason::requested), 0, moment.interval,
                              moment.bus, moment.wall_clock - moment.bus});
  }
}

void FlightTap::sent(can::Time at, const can::Frame& frame, can::SendResult result) noexcept {
  record(Kind::sent, at, at, static_cast<std::uint32_t>(result), frame);
}

void FlightTap::received(const can::ReceivedFrame& received) noexcept {
  record(received.own ? Kind::echo : Kind::received, received.end, received.end, 0, received.frame);
}

void FlightTap::left_out(cansync::Slot slot) noexcept {
  record(Kind::left_out, moment_.bus, moment_.bus, static_cast<std::uint32_t>(slot));
}

void FlightTap::report(const Report& report) noexcept {
  if (const auto* state = std::get_if<StateChanged>(&report)) {
    record(Kind::state, state->when.bus, state->when.bus, static_cast<std::uint32_t>(state->to));
  } else if (const auto* controller = std::get_if<ControllerChanged>(&report)) {
    record(Kind::controller, controller->when.bus, controller->when.bus,
           static_cast<std::uint32_t>(controller->to));
    fault(triggers_.bus_off && controller->to == can::ControllerState::bus_off, FlightReason::bus_off, 0,
          controller->when);
  } else if (const auto* missed = std::get_if<SyncsMissed>(&report)) {
    fault(triggers_.syncs_missed != 0 && missed->count >= triggers_.syncs_missed, FlightReason::syncs_missed,
          missed->count, missed->when);
  } else if (const auto* sending = std::get_if<SendingChanged>(&report)) {
    fault(triggers_.sending_failed && sending->result != can::SendResult::queued,
          FlightReason::sending_failed, static_cast<std::uint64_t>(sending->result), sending->when);
  } else if (const auto* link = std::get_if<LinkChanged>(&report)) {
    fault(triggers_.sending_failed && link->to != can::LinkState::up, FlightReason::sending_failed,
          static_cast<std::uint64_t>(can::SendResult::interface_down), link->when);
  } else if (const auto* delivery = std::get_if<DeliveryChanged>(&report)) {
    fault(triggers_.sending_failed && delivery->from == can::Delivery::normal, FlightReason::sending_failed,
          static_cast<std::uint64_t>(can::SendResult::not_delivered), delivery->when);
  } else if (const auto* event = std::get_if<EventReport>(&report)) {
    using Code = cansync::MasterEvent::Code;
    fault(triggers_.slave_lost && event->event.code == Code::slave_lost, FlightReason::slave_lost,
          event->event.slave ? event->event.slave->value() : 0U, event->when);
    fault(triggers_.second_master && event->event.code == Code::second_master, FlightReason::second_master,
          event->event.detail, event->when);
  }
}

void FlightTap::record(Kind kind, can::Time at, can::Time due, std::uint32_t value,
                       const can::Frame& frame) noexcept {
  recorder_.record({kind, value, moment_.interval, at, due, frame});
}

void FlightTap::fault(bool wanted, FlightReason reason, std::uint64_t detail, const Moment& when) noexcept {
  if (!wanted) return;
  recorder_.fault(
      {static_cast<std::uint32_t>(reason), detail, when.interval, when.bus, when.wall_clock - when.bus});
}

can::Wake RecordedBus::wait_until(can::Time deadline) noexcept {
  const can::Wake wake = bus_.wait_until(deadline);
  if (wake == can::Wake::deadline) tap_.woke(deadline, bus_.now());
  return wake;
}

bool RecordedBus::receive(can::ReceivedFrame& out) noexcept {
  if (!bus_.receive(out)) return false;
  tap_.received(out);
  return true;
}

can::SendResult RecordedBus::send(const can::Frame& frame) noexcept {
  const can::SendResult result = bus_.send(frame);
  tap_.sent(bus_.now(), frame, result);
  return result;
}

}  // namespace cansyncd
