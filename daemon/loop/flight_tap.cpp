#include "daemon/loop/flight_tap.h"

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

void FlightTap::left_out(std::uint32_t slot) noexcept {
  record(Kind::left_out, moment_.bus, moment_.bus, slot);
}

void FlightTap::state(const Moment& when, std::uint32_t state) noexcept {
  record(Kind::state, when.bus, when.bus, state);
}

void FlightTap::controller(const Moment& when, can::ControllerState state) noexcept {
  record(Kind::controller, when.bus, when.bus, static_cast<std::uint32_t>(state));
  if (state == can::ControllerState::bus_off) fault(FlightReason::bus_off, 0, when);
}

bool FlightTap::wanted(FlightReason reason, std::uint64_t detail) const noexcept {
  switch (reason) {
    case FlightReason::requested:
      return true;
    case FlightReason::bus_off:
      return triggers_.bus_off;
    case FlightReason::syncs_missed:
      return triggers_.syncs_missed != 0 && detail >= triggers_.syncs_missed;
    case FlightReason::slave_lost:
      return triggers_.slave_lost;
    case FlightReason::second_master:
      return triggers_.second_master;
    case FlightReason::sending_failed:
      return triggers_.sending_failed;
  }
  return false;
}

FaultEpisode& FlightTap::episode_of(FlightReason reason, std::uint64_t detail) noexcept {
  if (reason == FlightReason::slave_lost && detail < slaves_lost_.size()) return slaves_lost_.at(detail);
  return episodes_.at(static_cast<std::size_t>(reason));
}

void FlightTap::record(Kind kind, can::Time at, can::Time due, std::uint32_t value,
                       const can::Frame& frame) noexcept {
  recorder_.record({kind, value, moment_.interval, at, due, frame});
}

void FlightTap::fault(FlightReason reason, std::uint64_t detail, const Moment& when) noexcept {
  if (!wanted(reason, detail)) return;
  // What could not be written is as if it had not been recorded.
  if (recorder_.take_not_saved()) {
    for (FaultEpisode& one : episodes_) one.missed();
    for (FaultEpisode& one : slaves_lost_) one.missed();
  }
  FaultEpisode& episode = episode_of(reason, detail);
  if (!episode.begins(when.bus)) return recorder_.count_fault();
  if (!all_.allows(when.bus)) {
    episode.missed();
    return recorder_.count_fault();
  }
  const auto shown = recorder_.fault(
      {static_cast<std::uint32_t>(reason), detail, when.interval, when.bus, when.wall_clock - when.bus});
  if (shown == rt::FlightRecorder::Shown::none) return episode.missed();
  if (shown == rt::FlightRecorder::Shown::another) return;
  episode.recorded(when.bus);
  all_.count(when.bus);
}

can::Wake RecordedBus::woken(can::Time deadline, can::Wake wake) noexcept {
  if (wake == can::Wake::deadline) tap_.woke(deadline, behind_.now());
  return wake;
}

bool RecordedBus::receive(can::ReceivedFrame& out) noexcept {
  if (!behind_.receive(out)) return false;
  tap_.received(out);
  return true;
}

can::SendResult RecordedBus::send(const can::Frame& frame) noexcept {
  const can::SendResult result = behind_.send(frame);
  tap_.sent(behind_.now(), frame, result);
  return result;
}

}  // namespace cansyncd
