#pragma once

#include <memory>
#include <optional>

#include "can/bus.h"
#include "daemon/bus/bus_plan.h"
#include "sim/fault_script.h"
#include "sim/line.h"
#include "sim/trace_file.h"
#include "sync/sync_wire.h"

namespace cansyncd {

/// The fault script that `config` names for its simulated bus; an empty one when there is none. Main thread.
sim::FaultScript fault_script(const DaemonConfig& config, const sim::FaultProtocol& protocol);

/// The simulated line of a plan in real time: nodes, faults and trace. Built on the main thread;
/// afterwards `bus` belongs to the realtime thread.
class SimBus {
 public:
  /// Throws std::system_error when the trace file cannot be opened. Faults of
  /// the script that have errors are left out.
  explicit SimBus(BusPlan plan);

  can::Bus& bus() noexcept { return *line_; }
  sync_line::SyncWire& sync_wire() noexcept { return *line_; }
  /// The edges that a node made, on the clock of the bus.
  sync_line::Input& sync_edges() noexcept { return *line_; }

  /// Ends the trace, when there is one. The realtime thread must have ended. Main thread.
  std::optional<sim::TraceSummary> close_trace() noexcept;

 private:
  std::unique_ptr<sim::TraceFile> trace_;
  std::unique_ptr<sim::Line> line_;
};

}  // namespace cansyncd
