#include "daemon/bus/sim_bus.h"

#include <utility>

#include "cansync/sim/drive.h"
#include "cansync/sim/drive_faults.h"
#include "cansync/timing.h"
#include "daemon/bus/drive_settings.h"
#include "sim/fault_script.h"

namespace cansyncd {
namespace {

std::unique_ptr<sim::TraceFile> open_trace(const Config& config) {
  if (config.sim.trace.empty()) return nullptr;
  sim::TraceFileSettings settings;
  settings.path = config.sim.trace;
  settings.bus = config.bus.name;
  settings.background = true;  // the realtime thread must never wait for a file
  return std::make_unique<sim::TraceFile>(settings);
}

std::vector<std::unique_ptr<sim::Node>> drives(const Config& config) {
  std::vector<std::unique_ptr<sim::Node>> out;
  for (const cansync::SlaveNumber number : config.sim.drives)
    out.push_back(std::make_unique<sim::Drive>(drive_settings(config, number)));
  return out;
}

}  // namespace

std::vector<config::Problem> check_fault_script(const Config& config) {
  if (config.bus.kind != BusKind::simulated || config.sim.fault_script.empty()) return {};
  return sim::load_fault_script(config.sim.fault_script, sim::drive_faults()).errors;
}

SimBus::SimBus(const Config& config) : trace_(open_trace(config)) {
  sim::LineSettings settings;
  settings.bits_per_second = cansync::slot_times(config.master.bit_rate).bits_per_second;
  settings.clock = sim::ClockKind::real_time;
  settings.seed = config.sim.seed;
  settings.trace = trace_.get();
  settings.protocol = &sim::drive_faults();
  if (!config.sim.fault_script.empty()) {
    settings.faults = sim::load_fault_script(config.sim.fault_script, sim::drive_faults()).faults;
  }
  line_ = std::make_unique<sim::Line>(settings, drives(config));
}

std::optional<sim::TraceSummary> SimBus::close_trace() noexcept {
  if (trace_ == nullptr) return std::nullopt;
  return trace_->close();
}

}  // namespace cansyncd
