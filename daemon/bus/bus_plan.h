#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "can/bus.h"
#include "can/frame_filter.h"
#include "daemon_config/daemon_config.h"
#include "sim/fault_protocol.h"
#include "sim/node.h"

namespace cansyncd {

/// What stands on a simulated line beside the daemon.
struct SimPlan {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  /// What fault scripts know of the protocol; must outlive the bus. Null: there are no faults.
  const sim::FaultProtocol* faults = nullptr;
  /// Nothing: the daemon makes the SYNC edges. With a node that does: the daemon's number among the nodes.
  std::optional<sim::NodeNumber> daemon_number;
};

/// All that a bus has to know of the protocol that runs on it.
struct BusPlan {
  BusConfig bus;
  SimLineConfig line;  ///< of the simulated line
  /// Longest time after which the echo of a frame is missed; 0: never. Of the CAN interface.
  can::Time interval{};
  std::vector<can::FrameFilter> filters;  ///< what is received from a CAN interface, own frames too
  SimPlan sim;                            ///< needed with the simulated line alone
};

}  // namespace cansyncd
