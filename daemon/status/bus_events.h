#pragma once

#include <vector>

#include "can/bus.h"
#include "daemon/config/daemon_config.h"
#include "daemon/desk/event_text.h"

namespace cansyncd {

/// What is to be told when a bus changes from one state to another; may be empty. Allocates; not for the
/// realtime thread.
std::vector<EventText> bus_events(const can::ControllerStatus& from, const can::ControllerStatus& to,
                                  const BusConfig& bus);

}  // namespace cansyncd
