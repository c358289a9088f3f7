#include "daemon/cansync/status/master_metrics.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <utility>
#include <vector>

#include "cansync/master.h"
#include "cansync/settings/mode.h"
#include "cansync_members.h"
#include "daemon/status/common_metrics.h"
#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

constexpr double kNanoseconds = 1e9;  // in a second

/// The common source, with the samples themselves for what is not one member as it is.
struct MasterMetrics : MetricsSource {
  ToldStatus told;
};

/// A family's `fill`, of one that looks at the samples themselves.
template <auto fill>
void of_master(const MetricsSource& from, MetricSamples& to) {
  fill(static_cast<const MasterMetrics&>(from).told, to);
}

/// Slaves in a mask.
template <auto member>
void slaves_in(const ToldStatus& told, MetricSamples& to) {
  to.add({}, static_cast<std::uint64_t>(std::popcount(told.master->*member)));
}

/// An instant of telegrams that were seen; nothing for slots that had none.
template <auto member>
void slot_start(const ToldStatus& told, MetricSamples& to) {
  if (told.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    const cansync_SlotTiming& slot = told.timing->slot[i];
    if (slot.count != 0)
      to.add(label("slot", kSlotNames[i]), static_cast<double>(slot.*member) / kNanoseconds);
  }
}

void operating_state(const ToldStatus& told, MetricSamples& to) {
  using cansync::State;
  constexpr std::array kStates = {State::start_up, State::waiting_for_initialisation,
                                  State::waiting_for_start, State::setting_up_master, State::active_master};
  std::array<std::string_view, kStates.size()> words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = cansync::name(kStates[i]);
  add_states(to, "", words, gateway::dds::text(told.master->state));
}

void release_state(const ToldStatus& told, MetricSamples& to) {
  constexpr std::array<std::string_view, 3> kWords = {"released", "held", "stopped"};
  for (unsigned i = 0; i < cansync::kChannels; ++i) {
    add_states(to, label("telegram", fmt::format("{}", i + 1)), kWords,
               gateway::dds::text(told.master->reference_release[i].state));
  }
}

void slave_state(const ToldStatus& told, MetricSamples& to) {
  using cansync::SlaveState;
  for (const cansync_SlaveStatus* slave : told.slaves) {
    add_states(to, slave_labels(*slave),
               std::array{name(SlaveState::absent), name(SlaveState::starting), name(SlaveState::released),
                          name(SlaveState::lost), name(SlaveState::returning), name(SlaveState::checking),
                          name(SlaveState::held)},
               gateway::dds::text(slave->state));
  }
}

void slave_status_word(const ToldStatus& told, MetricSamples& to) {
  for (const cansync_SlaveStatus* slave : told.slaves) {
    if (slave->status_known) to.add(slave_labels(*slave), std::uint64_t{slave->status_word});
  }
}

void left_out(const ToldStatus& told, MetricSamples& to) {
  if (told.timing == nullptr) return;
  constexpr std::array<std::string_view, 3> kOfTheMaster = {"WRC1", "WRC2", "CC"};
  for (std::size_t i = 0; i < kOfTheMaster.size(); ++i)
    to.add(label("slot", kOfTheMaster[i]), std::uint64_t{told.timing->left_out[i]});
}

void planned_starts(const ToldStatus& told, MetricSamples& to) {
  if (told.timing == nullptr) return;
  for (std::size_t i = 0; i < kSlotNames.size(); ++i) {
    const std::int64_t start = told.timing->slot[i].planned_start;
    if (start >= 0) to.add(label("slot", kSlotNames[i]), static_cast<double>(start) / kNanoseconds);
  }
}

/// The topic has a count for each bucket, in 32 bits; here each counts everything up to its bound.
void lateness(const ToldStatus& told, MetricSamples& to) {
  if (told.timing == nullptr) return;
  const TimingSnapshot& timing = *told.timing_snapshot;
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

constexpr MetricFamily kMasterFamilies[] = {
    {"cansync_state", MetricType::gauge, "state", "MasterStatus.state",
     "1 for the operating state of the master, 0 for the others.", of_master<operating_state>},
    {"cansync_interval_length_seconds", MetricType::gauge, "", "MasterStatus.interval_length",
     "Length of an interval."},
    {"cansync_interval", MetricType::gauge, "", "MasterStatus.interval", "Number of the running interval."},
    {"cansync_slaves_configured", MetricType::gauge, "", "MasterStatus.slaves_configured",
     "Slaves in the configuration.", of_master<slaves_in<&cansync_MasterStatus::slaves_configured>>},
    {"cansync_slaves_responding", MetricType::gauge, "", "MasterStatus.slaves_responding",
     "Slaves that answer.", of_master<slaves_in<&cansync_MasterStatus::slaves_responding>>},
    {"cansync_slaves_synchronized", MetricType::gauge, "", "MasterStatus.slaves_synchronized",
     "Slaves that follow SYNC.", of_master<slaves_in<&cansync_MasterStatus::slaves_synchronized>>},
    {"cansync_slaves_wrong", MetricType::gauge, "", "MasterStatus.slaves_wrong",
     "Slaves that are held because they are not the drive expected.",
     of_master<slaves_in<&cansync_MasterStatus::slaves_wrong>>},
    {"cansync_slaves_duplicate", MetricType::gauge, "", "MasterStatus.slaves_duplicate",
     "Slaves as which two drives answer.", of_master<slaves_in<&cansync_MasterStatus::slaves_duplicate>>},
    {"cansync_slaves_unknown", MetricType::gauge, "", "MasterStatus.slaves_unknown",
     "Slaves that answer and are not in the configuration.",
     of_master<slaves_in<&cansync_MasterStatus::slaves_unknown>>},
    {"cansync_slaves_released", MetricType::gauge, "", "MasterStatus.slaves_released",
     "Slaves that may be used with references.",
     of_master<slaves_in<&cansync_MasterStatus::slaves_released>>},
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
    {"cansync_second_master_frames", MetricType::counter, "", "MasterStatus.second_master_frames",
     "Frames of another master."},
    {"cansync_second_master", MetricType::gauge, "", "MasterStatus.second_master",
     "1 while another master sends, else 0."},
    {"cansync_reference_release_state", MetricType::gauge, "telegram, state",
     "MasterStatus.reference_release.state",
     "1 for what happens to the reference values of the telegram, 0 for the others.",
     of_master<release_state>},
    {"cansync_reference_updates", MetricType::counter, "telegram", "MasterStatus.reference_release.updates",
     "Samples of reference values taken into use."},
    {"cansync_reference_too_old", MetricType::counter, "telegram", "MasterStatus.reference_release.too_old",
     "Times that reference values grew too old."},
    {"cansync_reference_refused", MetricType::counter, "telegram", "MasterStatus.reference_release.refused",
     "Samples of reference values that were beyond a limit or came from a waiting writer."},
    {"cansync_slave_state", MetricType::gauge, "slave, name, state", "SlaveStatus.state",
     "1 for the state of the slave, 0 for the others.", of_master<slave_state>},
    {"cansync_slave_responds", MetricType::gauge, "slave, name", "SlaveStatus.responds",
     "1 when the slave answers, else 0."},
    {"cansync_slave_synchronized", MetricType::gauge, "slave, name", "SlaveStatus.synchronized",
     "1 when the slave follows SYNC, else 0."},
    {"cansync_slave_status_word", MetricType::gauge, "slave, name", "SlaveStatus.status_word",
     "Status word of the slave; left out until it was read.", of_master<slave_status_word>},
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
     "Telegrams of the master that were left out, by slot.", of_master<left_out>},
    {"cansync_bus_load_ratio", MetricType::gauge, "", "Timing.bus_load",
     "Share of the last second in which the bus was busy."},
    {"cansync_sync_lateness_seconds", MetricType::histogram, "le", "Timing.lateness_histogram",
     "Wake-up of the realtime thread after the SYNC edge was due.", of_master<lateness>},
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
     of_master<slot_start<&cansync_SlotTiming::earliest>>},
    {"cansync_slot_start_mean_seconds", MetricType::gauge, "slot", "Timing.slot.mean",
     "Mean start of the telegrams after SYNC in the last second.",
     of_master<slot_start<&cansync_SlotTiming::mean>>},
    {"cansync_slot_start_latest_seconds", MetricType::gauge, "slot", "Timing.slot.latest",
     "Latest start of a telegram after SYNC in the last second.",
     of_master<slot_start<&cansync_SlotTiming::latest>>},
    {"cansync_slot_planned_start_seconds", MetricType::gauge, "slot", "Timing.slot.planned_start",
     "When the master means to start the telegram; left out for telegrams of slaves.",
     of_master<planned_starts>},
    {"cansync_slot_latest_start_seconds", MetricType::gauge, "slot", "Timing.slot.latest_start",
     "Latest start of the specification."},
    {"cansync_slot_late", MetricType::counter, "slot", "Timing.slot.late",
     "Telegrams that were started after the latest start."},
};

MetricTopic slave_topic(const std::vector<const cansync_SlaveStatus*>& slaves) {
  MetricTopic topic{"SlaveStatus", text::members_of<cansync_SlaveStatus>, {}};
  for (const cansync_SlaveStatus* slave : slaves) topic.samples.push_back({slave, slave_labels(*slave)});
  return topic;
}

constexpr auto kElementNames = std::to_array<ElementNames>({{"slot", kSlotNames}});

}  // namespace

std::string slave_labels(const cansync_SlaveStatus& slave) {
  return label("slave", fmt::format("{}", slave.slave)) + "," + label("name", gateway::dds::text(slave.name));
}

MetricFamilies master_metric_families() noexcept {
  return kMasterFamilies;
}

std::string master_metrics_text(const ToldCommon& common, const ToldStatus& told,
                                std::uint64_t write_failures) {
  MasterMetrics source{common_metrics(common, write_failures), told};
  source.element_names = kElementNames;
  source.topics.push_back(metric_topic("MasterStatus", *told.master));
  source.topics.push_back(slave_topic(told.slaves));
  MetricTopic timing{"Timing", text::members_of<cansync_Timing>, {}};
  if (told.timing != nullptr) timing.samples.push_back({told.timing, {}});
  source.topics.push_back(std::move(timing));
  return metrics_text(source, {common_metric_families(), master_metric_families()});
}

}  // namespace cansyncd
