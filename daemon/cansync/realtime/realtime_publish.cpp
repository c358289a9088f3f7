// What the realtime loop tells the gateway about itself.
#include <algorithm>
#include <chrono>

#include "daemon/bus/interface_status.h"
#include "daemon/cansync/realtime/realtime_loop.h"

namespace cansyncd {

using cansync::SlaveNumber;
using cansync::Slot;

void RealtimeLoop::publish() noexcept {
  const can::Time now = bus_.now();
  MasterSnapshot snapshot;
  reporter_.at(number_, now);
  const bool was_connected = watch_.connected();
  watch_.look(now);
  if (was_connected && !watch_.connected()) master_.bus_lost();
  if (watch_.away()) master_.bus_away();
  if (watch_.returned()) master_.bus_returned();
  snapshot.when = reporter_.moment();
  snapshot.state = master_.state();
  snapshot.cansync_status = cansync_status();
  snapshot.counters = master_.counters();
  snapshot.controller = watch_.status();
  snapshot.timestamps = bus_.timestamp_source();
  watch_other_master();
  snapshot.second_master = master_.second_master();
  snapshot.second_master_identifier = master_.second_master_identifier();
  snapshot.second_master_since = second_master_since_;
  snapshot.access = master_.access();
  snapshot.waits_for_command = mode_.waits_for_command();
  snapshot.waits_for_upper_sync = !mode_.sync_allowed();
  snapshot.configured = master_.settings().configured();
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    const cansync::SlaveStatus& status = master_.slave(slave);
    if (status.responds) snapshot.responding.set(slave);
    if (status.synchronized) snapshot.synchronized.set(slave);
    if (status.state == cansync::SlaveState::released) snapshot.released.set(slave);
    if (status.held && status.held->code == cansync::MasterEvent::Code::wrong_drive)
      snapshot.wrong.set(slave);
  }
  snapshot.duplicate = master_.duplicate_slaves();
  snapshot.unknown = master_.unknown_slaves();
  snapshot.open_parameter_jobs = static_cast<std::uint32_t>(master_.open_parameter_jobs());
  snapshot.open_transfers = static_cast<std::uint32_t>(master_.open_transfers());
  for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
    snapshot.release[cansync::index(channel)] = master_.release(channel);
    snapshot.lead_axis[cansync::index(channel)] =
        loop_.cluster != nullptr && loop_.cluster->lead().gives(channel);
  }
  snapshot.missed_syncs = missed_syncs_;
  snapshot.lost_reports = reporter_.lost_reports();
  follow_sync();
  snapshot.sync = line_;
  // Nobody is woken for it alone: what changed in it has been reported.
  exchange_.master.write(snapshot);
  refresh_slave_counters();
  if (now >= next_second_) publish_timing(now);
}

/// Since when another master sends, to the interval.
void RealtimeLoop::watch_other_master() noexcept {
  if (!master_.second_master()) {
    second_master_since_ = can::Time{0};
  } else if (second_master_since_ == can::Time{0}) {
    second_master_since_ = reporter_.moment().wall_clock;
  }
}

/// Slaves' counters change all the time; each slave's are told about once a second, one slave at a time.
void RealtimeLoop::refresh_slave_counters() noexcept {
  constexpr can::Time kSecond = std::chrono::seconds(1);
  const auto turn = static_cast<cansync::IntervalNumber>(
      std::max<can::Time::rep>(kSecond / interval_ / cansync::kSlaves, 1));
  if (timeline_.next() % turn != 0) return;
  const SlaveNumber slave = *SlaveNumber::from((timeline_.next() / turn) % cansync::kSlaves);
  if (master_.slave(slave).configured) reporter_.slave_status(slave, master_.slave(slave));
}

void RealtimeLoop::publish_timing(can::Time now) noexcept {
  constexpr can::Time kSecond = std::chrono::seconds(1);
  const auto lateness = lateness_.take();
  TimingSnapshot timing;
  timing.intervals = master_.counters().intervals;
  timing.lateness_minimum = lateness.minimum;
  timing.lateness_mean = lateness.mean;
  timing.lateness_maximum = lateness.maximum;
  timing.histogram = lateness_.histogram();
  timing.lateness_sum = lateness_.total();
  timing.left_out = left_out_;
  timing.missed_syncs = missed_syncs_;
  timing.bus_load = load_.take(now);
  timing.slots = slots_.take();
  for (const Slot slot : {Slot::reference_one, Slot::reference_two, Slot::command}) {
    timing.planned[static_cast<unsigned>(slot)] = master_.planned_start(slot);
  }
  exchange_.timing.write(timing);
  reporter_.written();
  lost_frames_ = watch_.status().lost_frames();
  next_second_ = std::max(next_second_ + kSecond, now);
  clock_.adjust(bus_);
}

/// Overrun: in the running second.
std::uint16_t RealtimeLoop::cansync_status() const noexcept {
  const can::ControllerStatus& controller = watch_.status();
  return interface_status({.lost_frames = controller.lost_frames() != lost_frames_,
                           .heard_others = heard_others_,
                           .echo_due = echo_due_,
                           .last_send = watch_.last_send()},
                          controller.state);
}

}  // namespace cansyncd
