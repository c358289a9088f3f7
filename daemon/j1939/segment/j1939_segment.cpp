#include "daemon/j1939/segment/j1939_segment.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <utility>

#include "can/frame_filter.h"
#include "daemon/j1939/segment/j1939_protocol.h"
#include "daemon/segment/segment_start.h"
#include "j1939/config/options.h"
#include "j1939/sim/ecu_faults.h"
#include "j1939/sim/ecu_node.h"
#include "sim/metronome.h"
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
    settings.counts = ecu.counts;
    plan.nodes.push_back(std::make_unique<sim::EcuNode>(std::move(settings)));
  }
  if (!config.sim.fault_script.empty())
    plan.nodes.push_back(std::make_unique<sim::Metronome>(sim::kFaultInterval));
  return plan;
}

/// Who wins when another node has the address.
std::string_view strength_text(const J1939Config& config) {
  const j1939::Name name = j1939::compose(config.name);
  if (!config.contest) return "a node that has the address keeps it";
  if (name == j1939::kWeakestName) return "every other NAME wins";
  if (name == 0) return "it wins against every other NAME";
  return "it takes the address from a node with a higher NAME";
}

/// The address and the NAME, for people.
std::string address_text(const J1939Config& config) {
  if (!config.preferred) return "without an address";
  return fmt::format("address {}, NAME {:016X} ({})", *config.preferred, j1939::compose(config.name),
                     strength_text(config));
}

}  // namespace

J1939File J1939Parts::load(const config::Source& source, std::span<const std::string> overrides) {
  return checked(load_j1939_config(source, overrides), sim::ecu_faults());
}

BusPlan J1939Parts::bus_plan(const J1939Config& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  plan.interval = kPatienceForEchoes;
  // Everything: the ranges are looked at by the node, and own frames must come back.
  plan.filters = {{.mask = 0, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either}};
  if (config.bus.kind == BusKind::simulated) plan.sim = ecu_plan(config);
  return plan;
}

MessageMachineSettings J1939Parts::machine_settings(const J1939Config& config, FlightTap* tap,
                                                    const SyncSources& /*sync*/) {
  MessageMachineSettings settings;
  settings.tap = tap;
  settings.bits_per_second = config.bus.bits_per_second;
  j1939::NodeSettings& node = settings.node;
  node.claim.preferred = config.preferred;
  node.claim.name = j1939::compose(config.name);
  node.claim.first_other = config.first_other;
  node.claim.last_other = config.last_other;
  node.claim.takes_commands = config.takes_commands;
  if (!config.contest) node.claim.ask_time = j1939::AddressClaim::kClaimTime;
  node.between_others = config.between_others;
  node.queue = config.send.queue;
  node.window = config.transport.window;
  node.most_bytes = config.transport.most_bytes;
  node.spacing = config.transport.interval;
  node.provided = config.provided;
  for (const j1939::PgnRange& range : config.receive) (void)node.filter.add(range);
  return settings;
}

std::string J1939Parts::words(const J1939Config& config) {
  return fmt::format("J1939, {}, {}", address_text(config), text::counted(config.receive.size(), "range"));
}

std::string J1939Parts::check_text(const J1939Config& config) {
  return fmt::format("J1939 at {} bit/s, {}, {} received\n", config.bus.bits_per_second, address_text(config),
                     text::counted(config.receive.size(), "range"));
}

const ProtocolInfo j1939_protocol = {kJ1939Protocol, j1939_options, load_for_deadline_segment<J1939Parts>,
                                     &j1939_document_heads};

}  // namespace cansyncd
