#include "daemon/cansync/segment/master_segment.h"

#include <fmt/format.h>

#include <utility>

#include "cansync/config/reload.h"
#include "cansync/settings/timing.h"
#include "daemon/cansync/bus/bus_plan.h"
#include "daemon/cansync/realtime/flight_reports.h"
#include "daemon/cansync/segment/load_checked.h"
#include "daemon/segment/segment_start.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

ExchangeSizes exchange_sizes(const Config& config) {
  return {config.realtime.request_queue,
          terminals_for(config.master.command_channel, config.realtime.request_queue),
          config.realtime.report_queue};
}

can::Time interval_of(const Config& config) {
  return cansync::slot_times(config.master.bit_rate).interval;
}

LoopSettings loop_settings(const Config& config, std::optional<StartTarget> first, FlightTap* tap,
                           sync_line::SyncWire* wire, SyncLine* sync_line) {
  LoopSettings settings;
  settings.first_target = first;
  settings.sync_wire = wire;
  settings.sync_line = sync_line;
  settings.target = config.startup.target;
  settings.after_other_master = config.startup.after_other_master;
  settings.report_intervals = config.dds.interval_topic;
  settings.tap = tap;
  // The simulated line costs no system call to look at.
  settings.look_at_every_slot = config.bus.kind == BusKind::simulated || config.bus.wake_on_frame;
  return settings;
}

}  // namespace

MasterSegment::MasterSegment(ConfigFile file, JournalSink& journal, gateway::dds::Participant participant,
                             Before before)
    : file_(std::move(file)),
      before_(std::move(before)),
      log_(file_.config.bus.name, journal),
      bus_(bus_plan(file_.config)),
      sync_line_(make_sync_line(file_.config, interval_of(file_.config), file_.settings, file_.path)),
      exchange_(exchange_sizes(file_.config)),
      participant_(std::move(participant)),
      gateway_(file_.config, exchange_, participant_, journal),
      flight_(
          file_.config, flight_protocol(interval_of(file_.config)), bus_.bus(),
          [this](const EventText& event) { gateway_.post(event); }, journal),
      loop_(file_.config.master,
            loop_settings(file_.config, before_.target, flight_.tap(), bus_.sync_wire(), sync_line_.get()),
            flight_.bus(), exchange_),
      threads_(log_, loop_, {log_, file_.config, bus_, flight_, gateway_, exchange_}) {}

MasterSegment::~MasterSegment() {
  stop();
}

void MasterSegment::start() {
  if (sync_line_) sync_line_->start();
  threads_.start(file_.config.realtime);
  if (!before_.changed.empty())
    gateway_.post({gateway_SEVERITY_INFO, "configuration_reloaded", -1,
                   fmt::format("the line is set up anew with another configuration; changed: {}",
                               fmt::join(before_.changed, ", ")),
                   std::nullopt});
  log_.say(LogPriority::notice, "daemon_running",
           fmt::format("running: bus {} ({}) at {} bit/s, {}, {}", file_.config.bus.name,
                       file_.config.bus.interface, file_.config.bus.bits_per_second,
                       text::counted(__builtin_popcount(file_.config.master.configured().bits), "slave"),
                       participant_.place()));
}

bool MasterSegment::stop_unless_active() noexcept {
  if (!loop_.request_stop_unless_active()) return false;
  stop();
  *target_at_stop_ = loop_.target_at_stop();
  return true;
}

void MasterSegment::stop() noexcept {
  threads_.stop();
}

ReloadPlan MasterSegment::plan_reload(std::span<const std::string> overrides) {
  ConfigFile wanted = load_checked(file_.path, overrides);
  if (auto wrong = refused_by_reload(wanted); !wrong.empty()) return {true, std::move(wrong), {}, {}, {}};
  ConfigReload changes = cansyncd::plan_reload(file_, wanted);
  const bool can_set_up = !changes.needs_set_up.empty() && changes.anew.problems.empty();
  const bool can_apply = changes.merged.problems.empty();
  if (!can_apply && !can_set_up) return {false, std::move(changes.merged.problems), {}, {}, {}};
  ReloadPlan plan{false, {}, std::move(changes.applied), std::move(changes.needs_restart), {}};
  plan.apply = [this, can_apply, merged = std::move(changes.merged)] {
    if (!can_apply) return;
    file_ = merged;
    gateway_.reload(file_.config);
  };
  if (!can_set_up) return plan;
  plan.needs_set_up = std::move(changes.needs_set_up);
  // What names a slave that comes with the others waits with them.
  if (!can_apply) {
    const std::vector<std::string> waiting = std::exchange(plan.applied, {});
    plan.needs_set_up.insert(plan.needs_set_up.end(), waiting.begin(), waiting.end());
  }
  // It keeps the participant of DDS, so that clients need not find the daemon anew.
  const auto participant = std::make_shared<gateway::dds::Participant>(participant_.once_more());
  const auto make = [&](ConfigFile file, std::vector<std::string> changed) {
    return [participant, file = std::move(file), changed = std::move(changed),
            target = target_at_stop_](JournalSink& journal) {
      return std::make_unique<MasterSegment>(file, journal, participant->once_more(),
                                             Before{changed, *target});
    };
  };
  plan.anew = make(std::move(changes.anew), plan.needs_set_up);
  plan.as_before = make(file_, {});
  return plan;
}

}  // namespace cansyncd
