#pragma once

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// A slave of one bus of CANsync that is the master of another.
extern const ProtocolInfo cansync_cluster_protocol;

}  // namespace cansyncd
