#include "daemon/cansync/bus/bus_plan.h"

#include <utility>

#include "cansync/config/drive_settings.h"
#include "cansync/settings/timing.h"
#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/telegram/telegram.h"

namespace cansyncd {
namespace {

/// Frames with the number of an identifier, whatever their flags: remote and extended ones come too, to be
/// counted, as they do not belong here.
can::FrameFilter frames_numbered(std::uint32_t identifier) {
  return {.identifier = identifier, .extended = can::FlagFilter::either, .remote = can::FlagFilter::either};
}

/// Likewise, for a whole channel.
can::FrameFilter frames_of_channel(std::uint32_t channel) {
  can::FrameFilter filter = frames_numbered(channel);
  filter.mask &= ~cansync::identifier::number_bits;
  return filter;
}

std::vector<can::FrameFilter> filters_of(const Config& config) {
  namespace identifier = cansync::identifier;
  std::vector<can::FrameFilter> filters = {
      frames_numbered(identifier::action), frames_of_channel(identifier::reference_one),
      frames_of_channel(identifier::reference_two), frames_of_channel(identifier::command)};
  if (config.sync.uses_frame()) filters.push_back(frames_numbered(config.sync.can_identifier));
  // The census asks every number, so every number may answer.
  if (config.master.startup.census) filters.push_back(frames_of_channel(identifier::response));
  for (const cansync::SlaveNumber number : config.master.configured()) {
    const std::uint32_t slave = number.value();
    filters.push_back(frames_numbered(identifier::actual_one + slave));
    filters.push_back(frames_numbered(identifier::actual_two + slave));
    if (!config.master.startup.census) filters.push_back(frames_numbered(identifier::response + slave));
  }
  return filters;
}

SimPlan sim_plan(const Config& config) {
  SimPlan plan;
  plan.faults = &sim::drive_faults();
  for (const cansync::SlaveNumber number : config.drives.slaves)
    plan.nodes.push_back(std::make_unique<sim::Drive>(drive_settings(config, number)));
  return plan;
}

}  // namespace

BusPlan bus_plan(const Config& config) {
  BusPlan plan;
  plan.bus = config.bus;
  plan.line = config.sim;
  plan.interval = cansync::slot_times(config.master.bit_rate).interval;
  plan.filters = filters_of(config);
  if (config.bus.kind == BusKind::simulated) plan.sim = sim_plan(config);
  return plan;
}

}  // namespace cansyncd
