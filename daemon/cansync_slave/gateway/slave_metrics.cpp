#include "daemon/cansync_slave/gateway/slave_metrics.h"

#include <array>
#include <string_view>

#include "cansync/settings/mode.h"
#include "cansync_slave_members.h"
#include "daemon/cansync_slave/gateway/slave_status.h"
#include "daemon/status/common_metrics.h"
#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

constexpr std::string_view kSlaveSideTopic = "SlaveSideStatus";

void slave_side_state(const MetricsSource& from, MetricSamples& to) {
  using cansync::State;
  constexpr std::array kStates = {State::start_up, State::waiting_for_initialisation,
                                  State::waiting_for_start, State::setting_up_slave, State::active_slave};
  std::array<std::string_view, kStates.size()> words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = cansync::name(kStates[i]);
  const auto& told = sample_of<cansync_slave_SlaveSideStatus>(kSlaveSideTopic, from);
  add_states(to, "", words, gateway::dds::text(told.state));
}

void slave_side_fault(const MetricsSource& from, MetricSamples& to) {
  using cansync::SlaveFault;
  const auto& told = sample_of<cansync_slave_SlaveSideStatus>(kSlaveSideTopic, from);
  add_states(to, "",
             std::array{word_of(SlaveFault::none), word_of(SlaveFault::sync_lost),
                        word_of(SlaveFault::references_missing)},
             gateway::dds::text(told.fault));
}

constexpr MetricFamily kSlaveFamilies[] = {
    {"cansync_slave_side_state", MetricType::gauge, "state", "SlaveSideStatus.state",
     "1 for the operating state of this slave, 0 for the others.", slave_side_state},
    {"cansync_slave_side_number", MetricType::gauge, "", "SlaveSideStatus.slave_number",
     "Slave number of the daemon on the bus."},
    {"cansync_slave_side_activated", MetricType::gauge, "", "SlaveSideStatus.activated",
     "1 when the master has activated SYNC operation, else 0."},
    {"cansync_slave_side_synchronized", MetricType::gauge, "", "SlaveSideStatus.synchronized",
     "1 when this slave follows SYNC, else 0."},
    {"cansync_slave_side_fault", MetricType::gauge, "state", "SlaveSideStatus.fault",
     "1 for the fault that stands, or none, 0 for the others.", slave_side_fault},
    {"cansync_slave_side_status_word", MetricType::gauge, "", "SlaveSideStatus.status_word",
     "Status word as the master reads it."},
    {"cansync_interval_length_seconds", MetricType::gauge, "", "SlaveSideStatus.interval_length",
     "Length of an interval."},
    {"cansync_interval", MetricType::gauge, "", "SlaveSideStatus.interval",
     "Number of the running interval."},
    {"cansync_bus_load_ratio", MetricType::gauge, "", "SlaveSideStatus.bus_load",
     "Share of the last second in which the bus was busy."},
    {"cansync_slave_side_missing_edges", MetricType::counter, "", "SlaveSideStatus.missing_edges",
     "Intervals that were run through without their SYNC edge."},
    {"cansync_slave_side_missing_in_row", MetricType::gauge, "", "SlaveSideStatus.missing_in_row",
     "Intervals in a row without reference values up to now."},
    {"cansync_slave_side_missing_references", MetricType::counter, "", "SlaveSideStatus.missing_references",
     "Intervals without reference values, after the first."},
    {"cansync_slave_side_reference_telegrams", MetricType::counter, "telegram",
     "SlaveSideStatus.reference_telegrams", "Telegrams of the master that brought reference values."},
    {"cansync_slave_side_actual_asked", MetricType::counter, "telegram", "SlaveSideStatus.asked",
     "Times that the master asked for actual values."},
    {"cansync_slave_side_actual_not_released", MetricType::counter, "telegram",
     "SlaveSideStatus.not_released", "Of those: nothing was released, so that no telegram went out."},
    {"cansync_slave_side_actual_released", MetricType::counter, "telegram", "SlaveSideStatus.released",
     "Releases of an application."},
    {"cansync_slave_side_actual_not_asked", MetricType::counter, "telegram", "SlaveSideStatus.not_asked",
     "Of those: not asked for while they waited, or replaced before."},
    {"cansync_slave_side_actual_sent", MetricType::counter, "telegram", "SlaveSideStatus.actual_sent",
     "Actual value telegrams that were on the bus."},
    {"cansync_slave_side_actual_late", MetricType::counter, "telegram", "SlaveSideStatus.actual_late",
     "Actual value telegrams that were left out because they would have started after their slot."},
    {"cansync_slave_side_actual_lost", MetricType::counter, "telegram", "SlaveSideStatus.actual_lost",
     "Actual value telegrams that were handed over and not seen on the bus."},
    {"cansync_slave_side_commands", MetricType::counter, "", "SlaveSideStatus.commands",
     "Parameter commands and transfers of the master that were answered."},
    {"cansync_slave_side_answers_busy", MetricType::counter, "", "SlaveSideStatus.answers_busy",
     "Of those: with busy."},
    {"cansync_slave_side_answers_sent", MetricType::counter, "", "SlaveSideStatus.answers_sent",
     "Answers that were on the bus."},
    {"cansync_slave_side_answers_late", MetricType::counter, "", "SlaveSideStatus.answers_late",
     "Answers that were left out because they would have started after their slot."},
    {"cansync_slave_side_answers_failed", MetricType::counter, "", "SlaveSideStatus.answers_failed",
     "Answers and actual values that the bus did not take."},
    {"cansync_slave_side_response_last_seconds", MetricType::gauge, "", "SlaveSideStatus.response_last",
     "From when the newest answer could go out to its being handed over."},
    {"cansync_slave_side_response_longest_seconds", MetricType::gauge, "", "SlaveSideStatus.response_longest",
     "The longest such time."},
    {"cansync_slave_side_actual_margin_least_seconds", MetricType::gauge, "",
     "SlaveSideStatus.actual_margin_least",
     "Least time from an actual value telegram being handed over to its latest start; 0 before the first."},
    {"cansync_slave_side_actions", MetricType::counter, "", "SlaveSideStatus.actions",
     "Actions of the master that name this slave."},
    {"cansync_slave_side_own_number_frames", MetricType::counter, "", "SlaveSideStatus.own_number_frames",
     "Frames of another node with an identifier of this slave."},
    {"cansync_slave_side_parameters", MetricType::gauge, "", "SlaveSideStatus.parameters",
     "Parameters in the daemon's own table, without the status word."},
    {"cansync_slave_side_taken_over", MetricType::gauge, "", "SlaveSideStatus.taken_over",
     "Parameters that an application has taken over."},
    {"cansync_slave_side_takes_blocks", MetricType::gauge, "", "SlaveSideStatus.takes_blocks",
     "1 when an application takes uploads and downloads, else 0."},
    {"cansync_slave_side_jobs", MetricType::counter, "", "SlaveSideStatus.jobs",
     "Parameter jobs that applications were asked for."},
    {"cansync_slave_side_jobs_answered", MetricType::counter, "", "SlaveSideStatus.jobs_answered",
     "Of those: the application's answer was on the bus."},
    {"cansync_slave_side_jobs_dropped", MetricType::counter, "", "SlaveSideStatus.jobs_dropped",
     "Of those: not wanted any more, or not answered in time."},
    {"cansync_slave_side_blocks", MetricType::counter, "", "SlaveSideStatus.blocks",
     "Uploads and downloads that applications were asked for."},
    {"cansync_slave_side_blocks_done", MetricType::counter, "", "SlaveSideStatus.blocks_done",
     "Of those: moved to the end."},
    {"cansync_slave_side_answers_unused", MetricType::counter, "", "SlaveSideStatus.answers_unused",
     "Answers of applications to what was not open any more."},
    {"cansync_slave_side_jobs_lost", MetricType::counter, "", "SlaveSideStatus.jobs_lost",
     "Steps of jobs and blocks that could not be told: no room."},
    {"cansync_slave_side_applications_refused", MetricType::counter, "",
     "SlaveSideStatus.applications_refused", "Samples of applications that wait for another one."},
    {"cansync_cluster_jobs_below", MetricType::counter, "", "SlaveSideStatus.jobs_below",
     "Of a cluster: parameter jobs that went down."},
    {"cansync_cluster_blocks_below", MetricType::counter, "", "SlaveSideStatus.blocks_below",
     "Of a cluster: uploads and downloads that went down."},
    {"cansync_cluster_unknown_below", MetricType::counter, "", "SlaveSideStatus.unknown_below",
     "Of a cluster: questions for a sub-slave that is not in its table."},
    {"cansync_cluster_repeated_below", MetricType::counter, "", "SlaveSideStatus.repeated_below",
     "Of a cluster: writes that came again and were answered from memory, not given below again."},
    {"cansync_cluster_sync_stops", MetricType::counter, "", "SlaveSideStatus.sync_stops",
     "Of a cluster: times the lower bus was stopped because the SYNC above was lost."},
    {"cansync_cluster_lead_given", MetricType::counter, "telegram", "SlaveSideStatus.lead_given",
     "Of a cluster: intervals in which the lead axis gave the telegram below."},
    {"cansync_cluster_lead_missing", MetricType::counter, "telegram", "SlaveSideStatus.lead_missing",
     "Of a cluster: intervals in which it was left out, for a value had not come."},
    {"cansync_cluster_lead_refused", MetricType::counter, "telegram", "SlaveSideStatus.lead_refused",
     "Of a cluster: intervals in which the master below did not take it."},
};

}  // namespace

MetricFamilies slave_metric_families() noexcept {
  return kSlaveFamilies;
}

std::string slave_metrics_text(const ToldCommon& common, const cansync_slave_SlaveSideStatus& told,
                               std::uint64_t write_failures) {
  return metrics_text(common, write_failures, metric_topic(kSlaveSideTopic, told), kSlaveFamilies);
}

}  // namespace cansyncd
