#include "j1939/sim/ecu_faults.h"

namespace sim {

const FaultProtocol& ecu_faults() noexcept {
  static const PlainFaults faults("ecu");
  return faults;
}

}  // namespace sim
