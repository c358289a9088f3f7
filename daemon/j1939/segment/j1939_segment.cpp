#include "daemon/j1939/segment/j1939_segment.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <utility>

#include "can/frame_filter.h"
#include "config/reload.h"
#include "daemon/segment/segment_start.h"
#include "j1939/sim/ecu_faults.h"
#include "j1939/sim/ecu_node.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

/// A frame without an echo for so long is taken as acknowledged by nobody.
constexpr can::Time kPatienceForEchoes = std::chrono::seconds(1);

SimPlan ecu_plan(const J1939Config& config) {
  SimPlan plan;
  plan.faults = &sim::ecu_faults();
  for (const SimEcuConfig& ecu : config.ecus) {
    sim::EcuSettings settings;
    settings.number = static_cast<sim::NodeNumber>(ecu.number);
    settings.claim.name = j1939::compose(ecu.name);
    settings.claim.preferred = ecu.address;
    settings.group = ecu.group;
    settings.priority = ecu.priority;
    settings.destination = ecu.destination;
    settings.data = ecu.data;
    settings.period = ecu.period;
    plan.nodes.push_back(std::make_unique<sim::EcuNode>(std::move(settings)));
  }
  return plan;
}

}  // namespace

std::string address_text(const J1939Config& config) {
  if (!config.preferred) return "without an address";
  return fmt::format("address {}, NAME {:016X}", *config.preferred, j1939::compose(config.name));
}

J1939File load_j1939_checked(const std::string& path, std::span<const std::string> overrides) {
  J1939File file = load_j1939_config(path, overrides);
  if (file.problems.empty()) {
    file.problems = check_surroundings(file.config, file.settings, path, sim::ecu_faults());
  }
  return file;
}

BusPlan j1939_bus_plan(const J1939Config& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  plan.interval = kPatienceForEchoes;
  // Everything: the ranges are looked at by the node, and own frames must come back.
  plan.filters = {{.mask = 0, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either}};
  if (config.bus.kind == BusKind::simulated) plan.sim = ecu_plan(config);
  return plan;
}

MessageMachineSettings message_machine_settings(const J1939Config& config, FlightTap* tap) {
  MessageMachineSettings settings;
  settings.tap = tap;
  settings.bits_per_second = config.bus.bits_per_second;
  j1939::NodeSettings& node = settings.node;
  node.claim.preferred = config.preferred;
  node.claim.name = j1939::compose(config.name);
  node.claim.first_other = config.first_other;
  node.claim.last_other = config.last_other;
  node.claim.takes_commands = config.takes_commands;
  node.between_others = config.between_others;
  node.queue = config.send.queue;
  node.window = config.transport.window;
  node.most_bytes = config.transport.most_bytes;
  node.spacing = config.transport.interval;
  node.provided = config.provided;
  for (const j1939::PgnRange& range : config.receive) (void)node.filter.add(range);
  return settings;
}

J1939Segment::J1939Segment(J1939File file, JournalSink& journal, gateway::dds::Participant participant)
    : file_(std::move(file)),
      log_(file_.config.bus.name, journal),
      bus_(j1939_bus_plan(file_.config)),
      exchange_(file_.config.realtime.request_queue, file_.config.realtime.report_queue,
                file_.config.transport.most_bytes),
      participant_(std::move(participant)),
      gateway_(file_.config, exchange_, participant_, journal),
      flight_(
          file_.config, FlightProtocol{}, bus_.bus(),
          [this](const EventText& event) { gateway_.post(event); }, journal),
      machine_(message_machine_settings(file_.config, flight_.tap()), flight_.bus(), exchange_),
      loop_(machine_, flight_.bus()),
      threads_(log_, loop_, {log_, file_.config, bus_, flight_, gateway_, exchange_}) {}

J1939Segment::~J1939Segment() {
  stop();
}

void J1939Segment::start() {
  threads_.start(file_.config.realtime);
  log_.say(
      LogPriority::notice, "daemon_running",
      fmt::format("running: bus {} ({}) at {} bit/s, J1939, {}, {}, {}", file_.config.bus.name,
                  file_.config.bus.interface, file_.config.bus.bits_per_second, address_text(file_.config),
                  text::counted(file_.config.receive.size(), "range"), participant_.place()));
}

void J1939Segment::stop() noexcept {
  threads_.stop();
}

ReloadPlan J1939Segment::plan_reload(std::span<const std::string> overrides) {
  J1939File wanted = load_j1939_checked(file_.path, overrides);
  if (!wanted.problems.empty()) return {true, std::move(wanted.problems), {}, {}, {}};
  config::Changes changes =
      config::compare(file_.settings, wanted.settings, [](const config::Setting&) { return true; });
  J1939File merged = build_j1939_config(std::move(changes.merged), file_.path);
  if (!merged.problems.empty()) return {false, std::move(merged.problems), {}, {}, {}};
  const auto apply = [this, merged = std::move(merged)] {
    file_ = merged;
    gateway_.reload(file_.config);
  };
  return {false, {}, std::move(changes.applied), std::move(changes.needs_restart), apply};
}

void J1939Segment::tell_reload(const ReloadPlan& plan) {
  if (!plan.problems.empty()) {
    gateway_.post({gateway_SEVERITY_ERROR, "reload_refused", -1, not_taken(plan), {}});
  } else if (!plan.needs_restart.empty()) {
    gateway_.post({gateway_SEVERITY_WARNING, "setting_needs_restart", -1, not_taken(plan), {}});
  }
}

}  // namespace cansyncd
