#include "daemon/cansync/status/metrics_families.h"

#include <fmt/format.h>

#include <array>
#include <bit>

#include "can/bus_names.h"
#include "cansync/master.h"
#include "cansync/settings/mode.h"
#include "dds/bounded_text.h"
#include "sync/phase_lock.h"

namespace cansyncd {
namespace {

constexpr double kNanoseconds = 1e9;  // in a second

using gateway::dds::text;

/// 1 for the word of `words` that is `current`, 0 for the others.
template <std::size_t count>
void add_states(MetricSamples& to, const std::string& labels,
                const std::array<std::string_view, count>& words, std::string_view current) {
  for (const std::string_view word : words) {
    to.add((labels.empty() ? "" : labels + ",") + label("state", word), std::uint64_t{word == current});
  }
}

/// Slaves in a mask.
template <auto member>
void slaves_in(const MetricsSource& from, MetricSamples& to) {
  to.add({}, static_cast<std::uint64_t>(std::popcount(from.master.*member)));
}

/// An instant of telegrams that were seen; nothing for slots that had none.
template <auto member>
void slot_start(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    const cansync_SlotTiming& slot = from.timing->slot[i];
    if (slot.count != 0)
      to.add(label("slot", kSlotNames[i]), static_cast<double>(slot.*member) / kNanoseconds);
  }
}

void info(const MetricsSource& from, MetricSamples& to) {
  const ToldCommon& common = from.common;
  to.add(label("version", text(common.gateway.version)) + "," +
             label("interface", text(common.bus.bus_interface)) + "," +
             label("dds_interface", text(common.gateway.dds_interface)) + "," +
             label("timestamp_source", text(common.bus.timestamp_source)),
         std::uint64_t{1});
}

void operating_state(const MetricsSource& from, MetricSamples& to) {
  using cansync::State;
  constexpr std::array kStates = {State::start_up, State::waiting_for_initialisation,
                                  State::waiting_for_start, State::setting_up_master, State::active_master};
  std::array<std::string_view, kStates.size()> words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = cansync::name(kStates[i]);
  add_states(to, "", words, text(from.master.state));
}

void controller_state(const MetricsSource& from, MetricSamples& to) {
  using can::ControllerState;
  add_states(to, "",
             std::array{name(ControllerState::error_active), name(ControllerState::error_warning),
                        name(ControllerState::error_passive), name(ControllerState::bus_off),
                        name(ControllerState::stopped)},
             text(from.common.bus.controller_state));
}

void link_state(const MetricsSource& from, MetricSamples& to) {
  using can::LinkState;
  add_states(to, "",
             std::array{name(LinkState::up), name(LinkState::down), name(LinkState::missing),
                        name(LinkState::wrong_bit_rate), name(LinkState::not_one_shot),
                        name(can::Delivery::unacknowledged), name(can::Delivery::not_emptied)},
             text(from.common.bus.link_state));
}

void sync_state(const MetricsSource& from, MetricSamples& to) {
  using sync_line::LockState;
  add_states(to, "",
             std::array{std::string_view(sync_line::name(LockState::searching)),
                        std::string_view(sync_line::name(LockState::locked)),
                        std::string_view(sync_line::name(LockState::holdover)),
                        std::string_view(sync_line::name(LockState::lost))},
             text(from.common.realtime.sync_state));
}

void release_state(const MetricsSource& from, MetricSamples& to) {
  constexpr std::array<std::string_view, 3> kWords = {"released", "held", "stopped"};
  for (unsigned i = 0; i < cansync::kChannels; ++i) {
    add_states(to, label("telegram", fmt::format("{}", i + 1)), kWords,
               text(from.master.reference_release[i].state));
  }
}

void slave_state(const MetricsSource& from, MetricSamples& to) {
  using cansync::SlaveState;
  for (const cansync_SlaveStatus* slave : from.slaves) {
    add_states(to, slave_labels(*slave),
               std::array{name(SlaveState::absent), name(SlaveState::starting), name(SlaveState::released),
                          name(SlaveState::lost), name(SlaveState::returning), name(SlaveState::checking),
                          name(SlaveState::held)},
               text(slave->state));
  }
}

void slave_status_word(const MetricsSource& from, MetricSamples& to) {
  for (const cansync_SlaveStatus* slave : from.slaves) {
    if (slave->status_known) to.add(slave_labels(*slave), std::uint64_t{slave->status_word});
  }
}

void left_out(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  constexpr std::array<std::string_view, 3> kOfTheMaster = {"WRC1", "WRC2", "CC"};
  for (std::size_t i = 0; i < kOfTheMaster.size(); ++i)
    to.add(label("slot", kOfTheMaster[i]), std::uint64_t{from.timing->left_out[i]});
}

void planned_start(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    const std::int64_t start = from.timing->slot[i].planned_start;
    if (start >= 0) to.add(label("slot", kSlotNames[i]), static_cast<double>(start) / kNanoseconds);
  }
}

/// The topic has a count for each bucket, in 32 bits; here each counts everything up to its bound.
void lateness(const MetricsSource& from, MetricSamples& to) {
  if (from.timing == nullptr) return;
  const TimingSnapshot& timing = from.timing_snapshot;
  std::uint64_t count = 0;
  for (std::size_t i = 0; i < timing.histogram.size(); ++i) {
    count += timing.histogram[i];
    const bool last = i + 1 == timing.histogram.size();
    const double bound = static_cast<double>(std::uint64_t{1} << i) / 1'000'000;
    to.add(label("le", last ? "+Inf" : fmt::format("{}", bound)), count, "_bucket");
  }
  to.add({}, count, "_count");
  to.add({}, static_cast<double>(timing.lateness_sum.count()) / kNanoseconds, "_sum");
}

void write_failures(const MetricsSource& from, MetricSamples& to) {
  to.add({}, from.write_failures);
}

constexpr MetricFamily kFamilies[] = {
    {"cansync_info", MetricType::gauge, "version, interface, dds_interface, timestamp_source",
     "GatewayStatus.version", "Always 1; the labels tell what runs.", info},
    {"cansync_state", MetricType::gauge, "state", "MasterStatus.state",
     "1 for the operating state of the master, 0 for the others.", operating_state},
    {"cansync_bit_rate_bits_per_second", MetricType::gauge, "", "BusStatus.bit_rate",
     "Bit rate of the bus as configured."},
    {"cansync_interval_length_seconds", MetricType::gauge, "", "MasterStatus.interval_length",
     "Length of an interval."},
    {"cansync_interval", MetricType::gauge, "", "MasterStatus.interval", "Number of the running interval."},
    {"cansync_slaves_configured", MetricType::gauge, "", "MasterStatus.slaves_configured",
     "Slaves in the configuration.", slaves_in<&cansync_MasterStatus::slaves_configured>},
    {"cansync_slaves_responding", MetricType::gauge, "", "MasterStatus.slaves_responding",
     "Slaves that answer.", slaves_in<&cansync_MasterStatus::slaves_responding>},
    {"cansync_slaves_synchronized", MetricType::gauge, "", "MasterStatus.slaves_synchronized",
     "Slaves that follow SYNC.", slaves_in<&cansync_MasterStatus::slaves_synchronized>},
    {"cansync_slaves_released", MetricType::gauge, "", "MasterStatus.slaves_released",
     "Slaves that may be used with references.", slaves_in<&cansync_MasterStatus::slaves_released>},
    {"cansync_open_parameter_jobs", MetricType::gauge, "", "MasterStatus.open_parameter_jobs",
     "Parameter jobs under way or waiting."},
    {"cansync_open_parameter_jobs_limit", MetricType::gauge, "", "MasterStatus.parameter_queue",
     "Most open parameter jobs."},
    {"cansync_open_transfers", MetricType::gauge, "", "MasterStatus.open_transfers",
     "Transfers under way or waiting."},
    {"cansync_open_transfers_limit", MetricType::gauge, "", "MasterStatus.transfer_queue",
     "Most open transfers."},
    {"cansync_telegrams_sent", MetricType::counter, "", "MasterStatus.telegrams_sent",
     "Telegrams handed to the bus."},
    {"cansync_references_not_released", MetricType::counter, "", "MasterStatus.references_not_released",
     "Reference value telegrams left out for want of values."},
    {"cansync_frames_rejected", MetricType::counter, "kind", "MasterStatus.frames_foreign...",
     "Received frames that are no telegrams, by kind."},
    {"cansync_frames_unexpected", MetricType::counter, "kind", "MasterStatus.unexpected_slave...",
     "Received telegrams that nobody waits for, by kind."},
    {"cansync_reports_lost", MetricType::counter, "", "RealtimeStatus.lost_reports",
     "Reports of the realtime thread for which there was no room."},
    {"cansync_controller_state", MetricType::gauge, "state", "BusStatus.controller_state",
     "1 for the state of the CAN controller, 0 for the others.", controller_state},
    {"cansync_controller_transmit_errors", MetricType::gauge, "", "BusStatus.transmit_errors",
     "Error counter of the CAN controller for sending; it falls again."},
    {"cansync_controller_receive_errors", MetricType::gauge, "", "BusStatus.receive_errors",
     "Error counter of the CAN controller for receiving; it falls again."},
    {"cansync_link_state", MetricType::gauge, "state", "BusStatus.link_state",
     "1 for the state of the CAN interface, 0 for the others.", link_state},
    {"cansync_error_frames", MetricType::counter, "", "BusStatus.error_frames", "Error frames on the bus."},
    {"cansync_acknowledge_errors", MetricType::counter, "", "BusStatus.acknowledge_errors",
     "Telegrams that nobody acknowledged."},
    {"cansync_bus_off_restarts", MetricType::counter, "", "BusStatus.restarts",
     "Times the controller left bus-off."},
    {"cansync_send_queue_full", MetricType::counter, "", "BusStatus.queue_full",
     "Telegrams left out because the send queue was full."},
    {"cansync_controller_overruns", MetricType::counter, "", "BusStatus.overruns",
     "Frames the controller had no room for."},
    {"cansync_frames_dropped", MetricType::counter, "", "BusStatus.dropped_frames",
     "Received frames lost before they were taken."},
    {"cansync_second_master_frames", MetricType::counter, "", "MasterStatus.second_master_frames",
     "Frames of another master."},
    {"cansync_second_master", MetricType::gauge, "", "MasterStatus.second_master",
     "1 while another master sends, else 0."},
    {"cansync_realtime_priority", MetricType::gauge, "", "RealtimeStatus.realtime_priority",
     "SCHED_FIFO priority granted; 0 is normal scheduling."},
    {"cansync_realtime_priority_wanted", MetricType::gauge, "", "RealtimeStatus.realtime_priority_wanted",
     "SCHED_FIFO priority as configured."},
    {"cansync_memory_locked", MetricType::gauge, "", "RealtimeStatus.memory_locked",
     "1 when all memory is locked, else 0."},
    {"cansync_sync_state", MetricType::gauge, "state", "RealtimeStatus.sync_state",
     "1 for the state of the timeline towards its SYNC source, 0 for the others; all 0 when it follows "
     "nothing.",
     sync_state},
    {"cansync_sync_phase_error_seconds", MetricType::gauge, "", "RealtimeStatus.sync_phase_error",
     "SYNC input after timeline, filtered."},
    {"cansync_sync_holdover_seconds", MetricType::gauge, "", "RealtimeStatus.sync_holdover",
     "For how long the edges of the SYNC input have been missing."},
    {"cansync_sync_edges", MetricType::counter, "", "RealtimeStatus.sync_edges",
     "Edges of the SYNC input that were used."},
    {"cansync_sync_rejected_edges", MetricType::counter, "", "RealtimeStatus.sync_rejected_edges",
     "Edges of the SYNC input that were not used."},
    {"cansync_sync_output_failures", MetricType::counter, "", "RealtimeStatus.sync_output_failures",
     "SYNC edges that could not be made."},
    {"cansync_clients", MetricType::gauge, "", "GatewayStatus.clients",
     "Programs with requests that the daemon knows."},
    {"cansync_requests_rejected", MetricType::counter, "reason", "GatewayStatus.rejected_values...",
     "Requests and samples of clients that were not taken, by reason."},
    {"cansync_reference_release_state", MetricType::gauge, "telegram, state",
     "MasterStatus.reference_release.state",
     "1 for what happens to the reference values of the telegram, 0 for the others.", release_state},
    {"cansync_reference_updates", MetricType::counter, "telegram", "MasterStatus.reference_release.updates",
     "Samples of reference values taken into use."},
    {"cansync_reference_too_old", MetricType::counter, "telegram", "MasterStatus.reference_release.too_old",
     "Times that reference values grew too old."},
    {"cansync_read_only", MetricType::gauge, "", "GatewayStatus.read_only",
     "1 when changes are refused, else 0."},
    {"cansync_secured", MetricType::gauge, "", "GatewayStatus.secured", "1 when DDS Security is on, else 0."},
    {"cansync_slave_state", MetricType::gauge, "slave, name, state", "SlaveStatus.state",
     "1 for the state of the slave, 0 for the others.", slave_state},
    {"cansync_slave_responds", MetricType::gauge, "slave, name", "SlaveStatus.responds",
     "1 when the slave answers, else 0."},
    {"cansync_slave_synchronized", MetricType::gauge, "slave, name", "SlaveStatus.synchronized",
     "1 when the slave follows SYNC, else 0."},
    {"cansync_slave_status_word", MetricType::gauge, "slave, name", "SlaveStatus.status_word",
     "Status word of the slave; left out until it was read.", slave_status_word},
    {"cansync_slave_status_error", MetricType::gauge, "slave, name", "SlaveStatus.status_error",
     "Code with which the slave refused its status word last; 0 when it gave it."},
    {"cansync_slave_last_seen_interval", MetricType::gauge, "slave, name", "SlaveStatus.last_seen",
     "Number of the interval in which the slave answered last."},
    {"cansync_slave_answers", MetricType::counter, "slave, name", "SlaveStatus.answers",
     "Answers of the slave."},
    {"cansync_slave_unanswered", MetricType::counter, "slave, name", "SlaveStatus.unanswered",
     "Commands that the slave did not answer."},
    {"cansync_slave_missed_actual", MetricType::counter, "slave, name", "SlaveStatus.missed_actual",
     "Actual value telegrams that did not come when asked for."},
    {"cansync_slave_slow_answers", MetricType::counter, "slave, name", "SlaveStatus.slow_answers",
     "Answers that came late."},
    {"cansync_slave_last_response_seconds", MetricType::gauge, "slave, name", "SlaveStatus.last_response",
     "End of the newest command to the end of its answer."},
    {"cansync_slave_longest_response_seconds", MetricType::gauge, "slave, name",
     "SlaveStatus.longest_response", "Longest time from the end of a command to the end of its answer."},
    {"cansync_slave_lost", MetricType::counter, "slave, name", "SlaveStatus.times_lost",
     "Times the slave stopped answering."},
    {"cansync_slave_returned", MetricType::counter, "slave, name", "SlaveStatus.times_returned",
     "Times the slave answered again."},
    {"cansync_slave_jobs_ended", MetricType::counter, "slave, name", "SlaveStatus.jobs_ended",
     "Jobs that ended because the slave stopped answering."},
    {"cansync_intervals", MetricType::counter, "", "Timing.intervals", "Intervals since the start."},
    {"cansync_syncs_missed", MetricType::counter, "", "Timing.missed_syncs", "SYNC edges skipped."},
    {"cansync_telegrams_left_out", MetricType::counter, "slot", "Timing.left_out",
     "Telegrams of the master that were left out, by slot.", left_out},
    {"cansync_bus_load_ratio", MetricType::gauge, "", "Timing.bus_load",
     "Share of the last second in which the bus was busy."},
    {"cansync_sync_lateness_seconds", MetricType::histogram, "le", "Timing.lateness_histogram",
     "Wake-up of the realtime thread after the SYNC edge was due.", lateness},
    {"cansync_sync_lateness_minimum_seconds", MetricType::gauge, "", "Timing.lateness_minimum",
     "Least lateness of the last second."},
    {"cansync_sync_lateness_mean_seconds", MetricType::gauge, "", "Timing.lateness_mean",
     "Mean lateness of the last second."},
    {"cansync_sync_lateness_maximum_seconds", MetricType::gauge, "", "Timing.lateness_maximum",
     "Greatest lateness of the last second."},
    {"cansync_slot_telegrams", MetricType::gauge, "slot", "Timing.slot.count",
     "Telegrams in the slot in the last second."},
    {"cansync_slot_start_earliest_seconds", MetricType::gauge, "slot", "Timing.slot.earliest",
     "Earliest start of a telegram after SYNC in the last second; left out when there was none.",
     slot_start<&cansync_SlotTiming::earliest>},
    {"cansync_slot_start_mean_seconds", MetricType::gauge, "slot", "Timing.slot.mean",
     "Mean start of the telegrams after SYNC in the last second.", slot_start<&cansync_SlotTiming::mean>},
    {"cansync_slot_start_latest_seconds", MetricType::gauge, "slot", "Timing.slot.latest",
     "Latest start of a telegram after SYNC in the last second.", slot_start<&cansync_SlotTiming::latest>},
    {"cansync_slot_planned_start_seconds", MetricType::gauge, "slot", "Timing.slot.planned_start",
     "When the master means to start the telegram; left out for telegrams of slaves.", planned_start},
    {"cansync_slot_latest_start_seconds", MetricType::gauge, "slot", "Timing.slot.latest_start",
     "Latest start of the specification."},
    {"cansync_slot_late", MetricType::counter, "slot", "Timing.slot.late",
     "Telegrams that were started after the latest start."},
    {"cansync_metrics_write_failures", MetricType::counter, "", "(no topic)",
     "Times this file could not be written.", write_failures},
};

}  // namespace

std::span<const MetricFamily> metric_families() noexcept {
  return kFamilies;
}

}  // namespace cansyncd
