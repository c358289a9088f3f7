#pragma once

#include "sim/fault_protocol.h"

namespace sim {

/// What faults have to know of J1939: nothing. Fault scripts name frames by identifier. Any thread.
const FaultProtocol& ecu_faults() noexcept;

}  // namespace sim
