#pragma once

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// J1939 on a bus.
extern const ProtocolInfo j1939_protocol;

}  // namespace cansyncd
