#include "daemon/layer2/segment/layer2_segment.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <utility>

#include "can/frame_filter.h"
#include "config/reload.h"
#include "daemon/layer2/config/module_settings.h"
#include "daemon/segment/segment_start.h"
#include "layer2/sim/frame_faults.h"
#include "layer2/sim/frame_node.h"
#include "sim/metronome.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

/// What intervals of fault scripts last, for there is no SYNC.
constexpr can::Time kFaultInterval = std::chrono::milliseconds(1);

/// A frame without an echo for so long is taken as acknowledged by nobody.
constexpr can::Time kEchoPatience = std::chrono::seconds(1);

SimPlan sim_plan(const Layer2Config& config) {
  SimPlan plan;
  plan.faults = &sim::frame_faults();
  for (const SimNodeConfig& node : config.nodes) {
    sim::FrameNodeSettings settings;
    settings.number = static_cast<sim::NodeNumber>(node.number);
    if (node.period.count() == 0) {
      settings.answers = {node.frame};
    } else {
      settings.periodic = node.frame;
      settings.period = node.period;
    }
    plan.nodes.push_back(std::make_unique<sim::FrameNode>(std::move(settings)));
  }
  if (!config.sim.fault_script.empty())
    plan.nodes.push_back(std::make_unique<sim::Metronome>(kFaultInterval));
  return plan;
}

}  // namespace

Layer2File load_layer2_checked(const std::string& path, std::span<const std::string> overrides) {
  Layer2File file = load_layer2_config(path, overrides);
  if (file.problems.empty()) {
    file.problems = check_surroundings(file.config, file.settings, path, sim::frame_faults());
  }
  return file;
}

BusPlan layer2_bus_plan(const Layer2Config& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  plan.interval = kEchoPatience;
  // Everything: the ranges are looked at by the station, and own frames must come back.
  plan.filters = {{.mask = 0, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either}};
  if (config.bus.kind == BusKind::simulated) plan.sim = sim_plan(config);
  return plan;
}

FrameMachineSettings frame_machine_settings(const Layer2Config& config, FlightTap* tap) {
  FrameMachineSettings settings;
  settings.tap = tap;
  settings.bits_per_second = config.bus.bits_per_second;
  settings.module = module_settings(config);
  return settings;
}

Layer2Segment::Layer2Segment(Layer2File file, JournalSink& journal, gateway::dds::Participant participant)
    : file_(std::move(file)),
      log_(file_.config.bus.name, journal),
      bus_(layer2_bus_plan(file_.config)),
      exchange_(file_.config.realtime.request_queue, file_.config.realtime.report_queue),
      participant_(std::move(participant)),
      gateway_(file_, exchange_, participant_, journal),
      flight_(
          file_.config, FlightProtocol{}, bus_.bus(),
          [this](const EventText& event) { gateway_.post(event); }, journal),
      machine_(frame_machine_settings(file_.config, flight_.tap()), flight_.bus(), exchange_),
      loop_(machine_, flight_.bus()),
      threads_(log_, loop_, {log_, file_.config, bus_, flight_, gateway_, exchange_}) {}

Layer2Segment::~Layer2Segment() {
  stop();
}

void Layer2Segment::start() {
  threads_.start(file_.config.realtime);
  log_.say(LogPriority::notice, "daemon_running",
           fmt::format("running: bus {} ({}) at {} bit/s, general frames, {}, {}", file_.config.bus.name,
                       file_.config.bus.interface, file_.config.bus.bits_per_second,
                       text::counted(file_.config.receive.size(), "range"), participant_.place()));
}

void Layer2Segment::stop() noexcept {
  threads_.stop();
}

ReloadPlan Layer2Segment::plan_reload(std::span<const std::string> overrides) {
  Layer2File wanted = load_layer2_checked(file_.path, overrides);
  if (!wanted.problems.empty()) return {true, std::move(wanted.problems), {}, {}, {}};
  config::Changes changes =
      config::compare(file_.settings, wanted.settings, [](const config::Setting&) { return true; });
  Layer2File merged = build_layer2_config(std::move(changes.merged), file_.path);
  if (!merged.problems.empty()) return {false, std::move(merged.problems), {}, {}, {}};
  const auto apply = [this, merged = std::move(merged)] {
    file_ = merged;
    gateway_.reload(file_.config);
  };
  return {false, {}, std::move(changes.applied), std::move(changes.needs_restart), apply};
}

void Layer2Segment::tell_reload(const ReloadPlan& plan) {
  if (!plan.problems.empty()) {
    gateway_.post({gateway_SEVERITY_ERROR, "reload_refused", -1, not_taken(plan), {}});
  } else if (!plan.needs_restart.empty()) {
    gateway_.post({gateway_SEVERITY_WARNING, "setting_needs_restart", -1, not_taken(plan), {}});
  }
}

}  // namespace cansyncd
