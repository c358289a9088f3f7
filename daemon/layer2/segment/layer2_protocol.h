#pragma once

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// General CAN frames on a bus.
extern const ProtocolInfo layer2_protocol;

}  // namespace cansyncd
