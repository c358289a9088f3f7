#pragma once

#include <vector>

#include "can/bus.h"
#include "can/link_facts.h"
#include "daemon/desk/event_text.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// What is to be told when a bus changes from one state to another; may be empty. `link`: its interface as it
/// was found last. Allocates; not for the realtime thread.
std::vector<EventText> bus_events(const can::ControllerStatus& from, const can::ControllerStatus& to,
                                  const BusConfig& bus, const can::LinkFacts& link);

/// What is to be told of the state of an interface that `to` has now.
EventText link_event(const can::ControllerStatus& to, const BusConfig& bus, const can::LinkFacts& link);

}  // namespace cansyncd
