#pragma once

#include "sim/fault_protocol.h"

namespace sim {

/// What faults have to know of general frames: nothing. Fault scripts name frames by identifier. Any thread.
const FaultProtocol& frame_faults() noexcept;

}  // namespace sim
