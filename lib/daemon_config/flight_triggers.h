#pragma once

#include <cstdint>

namespace cansyncd {

/// Which faults lead to a flight recording. Plain values.
struct FlightTriggers {
  bool bus_off = true;
  std::uint32_t syncs_missed = 10;  ///< SYNC edges skipped in a row, at least; 0: never
  bool slave_lost = true;
  bool second_master = true;
  bool sending_failed = true;  ///< telegrams cannot be handed to the bus: queue full, interface down
};

}  // namespace cansyncd
