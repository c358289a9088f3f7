#pragma once

#include "daemon/cansync/exchange.h"
#include "daemon/loop/flight_tap.h"

namespace cansyncd {

/// Tells the flight recorder what the realtime thread reports: states are kept, and what is a fault freezes
/// it. Realtime safe.
void tell(FlightTap& tap, const Report& report) noexcept;

/// The names of slots and states, for the headers of recordings. `interval`: tSYNC.
FlightProtocol flight_protocol(can::Time interval) noexcept;

}  // namespace cansyncd
