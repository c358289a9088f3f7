#include "daemon/cansync_cluster/segment/cluster_segment.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "cansync/settings/timing.h"
#include "cansync/sim/drive_faults.h"
#include "cansync_cluster/config/options.h"
#include "config/reload.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/realtime/flight_reports.h"
#include "daemon/cansync_slave/segment/slave_segment.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

can::Time interval_of(const ClusterConfig& config) {
  return cansync::slot_times(config.lower.master.bit_rate).interval;
}

ExchangeSizes lower_sizes(const ClusterConfig& config) {
  const RealtimeConfig& realtime = config.lower.realtime;
  return {realtime.request_queue, terminals_for(config.lower.master.command_channel, realtime.request_queue),
          realtime.report_queue};
}

SlaveMachineSettings upper_settings(const ClusterConfig& config, FlightTap* tap,
                                    const SyncFollower::Inputs& inputs, cansync::Cluster& cluster,
                                    LeadingEdges& edges) {
  SlaveMachineSettings settings = slave_machine_settings(config.upper, tap, inputs);
  settings.cluster = &cluster;
  settings.edges = &edges;
  return settings;
}

LoopSettings lower_settings(const ClusterConfig& config, FlightTap* tap, BusChoice& bus, SyncLine* sync_line,
                            cansync::Cluster& cluster, const LeadingEdges& edges) {
  LoopSettings settings;
  settings.target = config.lower.startup.target;
  settings.after_other_master = config.lower.startup.after_other_master;
  settings.report_intervals = config.lower.dds.interval_topic;
  settings.tap = tap;
  settings.sync_wire = bus.sync_wire();
  settings.sync_line = sync_line;
  // The simulated line costs no system call to look at.
  settings.look_at_every_slot = config.lower.bus.kind == BusKind::simulated;
  settings.cluster = &cluster;
  settings.edges = &edges;
  return settings;
}

/// What differs, by level; the keys of common options stand in each level's settings, too.
void add_changes(std::string_view level, const std::vector<config::Setting>& running,
                 const std::vector<config::Setting>& wanted, std::vector<std::string>& keys) {
  const auto none = [](const config::Setting&) { return false; };
  for (const std::string& key : config::compare(running, wanted, none).needs_restart) {
    const bool common = cluster_options().find(key) != nullptr;
    if (level.empty() || !common) keys.push_back(level.empty() ? key : fmt::format("{}.{}", level, key));
  }
}

}  // namespace

ClusterFile load_cluster_checked(const config::Source& source, std::span<const std::string> overrides) {
  ClusterFile file = load_cluster_config(source, overrides);
  if (!file.problems.empty()) return file;
  const auto check = [&](const DaemonConfig& config, const std::vector<config::Setting>& settings) {
    check_surroundings(config, settings, source.path, sim::drive_faults(), file.problems,
                       file.script_problems);
  };
  check(file.config.upper, file.upper.settings);
  check(file.config.lower, file.lower.settings);
  return file;
}

ClusterSegment::ClusterSegment(ClusterFile file, JournalSink& journal, gateway::dds::Participant upper,
                               gateway::dds::Participant lower)
    : file_(std::move(file)),
      upper_log_(file_.config.upper.bus.name, journal),
      lower_log_(file_.config.lower.bus.name, journal),
      upper_bus_(slave_bus_plan(file_.config.upper)),
      lower_bus_(bus_plan(file_.config.lower)),
      upper_sync_(
          make_sync_line(file_.config.upper, interval_of(file_.config), file_.upper.settings, file_.path)),
      lower_sync_(
          make_sync_line(file_.config.lower, interval_of(file_.config), file_.lower.settings, file_.path)),
      cluster_(file_.config.cluster),
      upper_exchange_(file_.config.upper.realtime.report_queue),
      lower_exchange_(lower_sizes(file_.config)),
      upper_participant_(std::move(upper)),
      lower_participant_(std::move(lower)),
      upper_gateway_(file_.config.upper, upper_exchange_, upper_participant_, journal),
      lower_gateway_(file_.config.lower, lower_exchange_, lower_participant_, journal),
      upper_flight_(
          file_.config.upper, FlightProtocol{.interval = interval_of(file_.config)}, upper_bus_.bus(),
          [this](const EventText& event) { upper_gateway_.post(event); }, journal),
      machine_(upper_settings(file_.config, upper_flight_.tap(), {upper_sync_.get(), upper_bus_.sync_edges()},
                              cluster_, edges_),
               upper_flight_.bus(), upper_exchange_),
      // The thread wakes at each slot of the lower bus anyhow.
      upper_loop_(machine_, upper_flight_.bus(), interval_of(file_.config)),
      both_(lower_bus_.bus(), upper_loop_),
      lower_flight_(
          file_.config.lower, flight_protocol(interval_of(file_.config)), both_,
          [this](const EventText& event) { lower_gateway_.post(event); }, journal),
      lower_loop_(
          file_.config.lower.master,
          lower_settings(file_.config, lower_flight_.tap(), lower_bus_, lower_sync_.get(), cluster_, edges_),
          lower_flight_.bus(), lower_exchange_),
      loop_(both_, lower_loop_),
      threads_(upper_log_, loop_,
               {upper_log_, file_.config.upper, upper_bus_, upper_flight_, upper_gateway_, upper_exchange_},
               {lower_log_, file_.config.lower, lower_bus_, lower_flight_, lower_gateway_, lower_exchange_}) {
}

ClusterSegment::~ClusterSegment() {
  stop();
}

void ClusterSegment::start() {
  if (upper_sync_) upper_sync_->start();
  if (lower_sync_) lower_sync_->start();
  threads_.start(file_.config.upper.realtime);
  const SlaveRoleConfig& upper = file_.config.upper;
  const Config& lower = file_.config.lower;
  upper_log_.say(
      LogPriority::notice, "daemon_running",
      fmt::format("running: bus {} ({}) at {} bit/s, slave {}, {}", upper.bus.name, upper.bus.interface,
                  upper.bus.bits_per_second, upper.slave.number.value(), upper_participant_.place()));
  lower_log_.say(LogPriority::notice, "daemon_running",
                 fmt::format("running: bus {} ({}) at {} bit/s, {}, {}", lower.bus.name, lower.bus.interface,
                             lower.bus.bits_per_second,
                             text::counted(__builtin_popcount(lower.master.configured().bits), "slave"),
                             lower_participant_.place()));
}

void ClusterSegment::stop() noexcept {
  threads_.stop();
}

/// The gateways have come further when both have.
Heartbeat::Progress ClusterSegment::progress() const noexcept {
  const Heartbeat::Progress passes{upper_gateway_.passes(), lower_gateway_.passes()};
  if (passes.further_than(passes_)) {
    passes_ = passes;
    ++both_further_;
  }
  return {loop_.wake_ups(), both_further_};
}

bool ClusterSegment::record() noexcept {
  const bool upper = upper_flight_.request();
  return lower_flight_.request() || upper;
}

void ClusterSegment::set_surroundings(const Surroundings& surroundings) {
  upper_gateway_.set_surroundings(surroundings);
  lower_gateway_.set_surroundings(surroundings);
}

ReloadPlan ClusterSegment::plan_reload(std::span<const std::string> overrides) {
  ClusterFile wanted = load_cluster_checked(file_.path, overrides);
  if (wanted.problems.empty()) wanted.problems = wanted.lower.profile_problems;
  if (!wanted.problems.empty()) return {true, std::move(wanted.problems), {}, {}, {}};
  ReloadPlan plan;
  add_changes("", file_.settings, wanted.settings, plan.needs_restart);
  add_changes("upper", file_.upper.settings, wanted.upper.settings, plan.needs_restart);
  add_changes("lower", file_.lower.settings, wanted.lower.settings, plan.needs_restart);
  plan.apply = [] {};
  return plan;
}

}  // namespace cansyncd
