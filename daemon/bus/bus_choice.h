#pragma once

#include <optional>
#include <utility>

#include "daemon/bus/bus_plan.h"
#include "daemon/bus/sim_bus.h"
#include "daemon/bus/socketcan_line.h"
#include "sync/input.h"
#include "sync/sync_wire.h"

namespace cansyncd {

/// The bus that a plan names: the simulated line or a CAN interface. Main thread, but for what `bus`
/// gives.
class BusChoice {
 public:
  /// Throws what the chosen one throws; all of it is a std::exception that says what to do.
  explicit BusChoice(BusPlan plan) {
    if (plan.bus.kind == BusKind::simulated) {
      simulated_.emplace(std::move(plan));
    } else {
      socketcan_.emplace(plan);
    }
  }

  /// Belongs to the realtime thread once that runs.
  can::Bus& bus() noexcept { return simulated_ ? simulated_->bus() : socketcan_->bus(); }

  /// The SYNC wire beside the bus; null: a CAN interface has none. Likewise the realtime thread's.
  sync_line::SyncWire* sync_wire() noexcept { return simulated_ ? &simulated_->sync_wire() : nullptr; }

  /// The SYNC edges that a simulated master makes, on the clock of the bus; null: a CAN interface brings
  /// none. Likewise the realtime thread's.
  sync_line::Input* sync_edges() noexcept { return simulated_ ? &simulated_->sync_edges() : nullptr; }

  /// What people should know of the interface as it was found; empty: nothing.
  std::string advice() const { return socketcan_ ? socketcan_->advice() : std::string(); }

  /// Once the realtime thread runs. `listener` is told of a CAN interface's state on a thread of the bus;
  /// what it uses must live until `stop`.
  void start(LinkListener listener) {
    if (socketcan_) socketcan_->start(std::move(listener));
  }

  /// After the realtime thread has ended.
  void stop() noexcept {
    if (socketcan_) socketcan_->stop();
  }

  /// Ends the simulated line's trace, when there is one. The realtime thread must have ended.
  std::optional<sim::TraceSummary> close_trace() noexcept {
    return simulated_ ? simulated_->close_trace() : std::nullopt;
  }

 private:
  std::optional<SimBus> simulated_;
  std::optional<SocketcanLine> socketcan_;
};

}  // namespace cansyncd
