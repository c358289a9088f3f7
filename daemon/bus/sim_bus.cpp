#include "daemon/bus/sim_bus.h"

#include <chrono>
#include <utility>

namespace cansyncd {
namespace {

std::unique_ptr<sim::TraceFile> open_trace(const BusPlan& plan) {
  if (plan.line.trace.empty()) return nullptr;
  sim::TraceFileSettings settings;
  settings.path = plan.line.trace;
  settings.bus = plan.bus.name;
  // Stamps that can be laid beside those of recordings, events and flight records.
  settings.offset = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch() -
      std::chrono::steady_clock::now().time_since_epoch());
  settings.background = true;  // the realtime thread must never wait for a file
  return std::make_unique<sim::TraceFile>(settings);
}

}  // namespace

sim::FaultScript fault_script(const DaemonConfig& config, const sim::FaultProtocol& protocol) {
  if (config.bus.kind != BusKind::simulated || config.sim.fault_script.empty()) return {};
  return sim::load_fault_script(config.sim.fault_script, protocol);
}

SimBus::SimBus(BusPlan plan) : trace_(open_trace(plan)) {
  sim::LineSettings settings;
  settings.bits_per_second = plan.bus.bits_per_second;
  settings.clock = sim::ClockKind::real_time;
  settings.seed = plan.line.seed;
  settings.trace = trace_.get();
  settings.protocol = plan.sim.faults;
  settings.user_number = plan.sim.daemon_number;
  if (plan.sim.faults != nullptr && !plan.line.fault_script.empty())
    settings.faults = sim::load_fault_script(plan.line.fault_script, *plan.sim.faults).faults;
  line_ = std::make_unique<sim::Line>(settings, std::move(plan.sim.nodes));
}

std::optional<sim::TraceSummary> SimBus::close_trace() noexcept {
  if (trace_ == nullptr) return std::nullopt;
  return trace_->close();
}

}  // namespace cansyncd
