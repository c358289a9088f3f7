#include "daemon/layer2/segment/layer2_segment.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <utility>

#include "can/frame_filter.h"
#include "daemon/layer2/segment/layer2_protocol.h"
#include "daemon/segment/segment_start.h"
#include "layer2/config/module_settings.h"
#include "layer2/config/options.h"
#include "layer2/sim/frame_faults.h"
#include "layer2/sim/frame_node.h"
#include "sim/metronome.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

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
    plan.nodes.push_back(std::make_unique<sim::Metronome>(sim::kFaultInterval));
  return plan;
}

}  // namespace

Layer2File Layer2Parts::load(const config::Source& source, std::span<const std::string> overrides) {
  return checked(load_layer2_config(source, overrides), sim::frame_faults());
}

BusPlan Layer2Parts::bus_plan(const Layer2Config& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  plan.interval = kEchoPatience;
  // Everything: the ranges are looked at by the station, and own frames must come back.
  plan.filters = {{.mask = 0, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either}};
  if (config.bus.kind == BusKind::simulated) plan.sim = sim_plan(config);
  return plan;
}

FrameMachineSettings Layer2Parts::machine_settings(const Layer2Config& config, FlightTap* tap,
                                                   const SyncSources& /*sync*/) {
  FrameMachineSettings settings;
  settings.tap = tap;
  settings.bits_per_second = config.bus.bits_per_second;
  settings.module = module_settings(config);
  return settings;
}

namespace {

/// The ranges do not count beside a filter by node.
std::string received_text(const Layer2Config& config) {
  if (config.node_filter != 0) return fmt::format("frames of node {}", config.node_filter);
  return text::counted(config.receive.size(), "range");
}

}  // namespace

std::string Layer2Parts::words(const Layer2Config& config) {
  return fmt::format("general frames, {}", received_text(config));
}

std::string Layer2Parts::check_text(const Layer2Config& config) {
  return fmt::format("general frames at {} bit/s, {} received\n", config.bus.bits_per_second,
                     received_text(config));
}

const ProtocolInfo layer2_protocol = {kLayer2Protocol, layer2_options, load_for_deadline_segment<Layer2Parts>,
                                      &layer2_document_heads};

}  // namespace cansyncd
