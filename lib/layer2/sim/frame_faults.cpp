#include "layer2/sim/frame_faults.h"

namespace sim {

const FaultProtocol& frame_faults() noexcept {
  static const PlainFaults faults("node");
  return faults;
}

}  // namespace sim
