#pragma once

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// A slave of CANsync on a line that another one's master drives.
extern const ProtocolInfo cansync_slave_protocol;

}  // namespace cansyncd
