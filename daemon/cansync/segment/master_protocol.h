#pragma once

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// The master of a CANsync line.
extern const ProtocolInfo cansync_protocol;

}  // namespace cansyncd
