#pragma once

#include "sim/fault_protocol.h"

namespace sim {

/// What faults have to know of CANsync. Lives as long as the program.
const FaultProtocol& drive_faults() noexcept;

}  // namespace sim
