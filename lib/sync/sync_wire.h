#pragma once

#include "can/bus.h"

namespace sync_line {

/// The wire that carries the SYNC edge to the slaves, where one belongs to the bus: that of a simulated line.
/// Outputs of a real one are gpio.h and phc_output.h.
class SyncWire {
 public:
  virtual ~SyncWire() = default;

  /// Produces the edge that stands for `due`; called as close after `due` as the thread wakes. Realtime
  /// thread, the one that drives the bus; nothing allocates, locks, logs or throws.
  virtual void sync_edge(can::Time due) noexcept = 0;
};

}  // namespace sync_line
