#pragma once

#include "cansync/config/config.h"
#include "daemon/bus/bus_plan.h"

namespace cansyncd {

/// What a bus has to know of a master with this configuration.
///
/// It receives actual values and responses of the configured slaves; the identifiers of a master, for its own
/// echoes and to notice a second one; and the software SYNC frame, when the timeline follows it or the line
/// sends it. A simulated line has the configured drives. Main thread.
BusPlan bus_plan(const Config& config);

}  // namespace cansyncd
