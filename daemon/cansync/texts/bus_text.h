#pragma once

#include <string>

#include "can/bus_names.h"
#include "cansync.h"
#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/texts/event_text.h"

/// State and faults of the bus in words. Pure functions; not for the realtime thread (they allocate).
namespace cansyncd {

/// The event that stands for a change of the interface: what happened, why nothing is sent, and the remedy.
EventText describe_link(const LinkChanged& report, const Config& config, const can::LinkFacts& link = {});

/// The event that stands for a fault that began or is over.
EventText describe_fault(const BusFault& report);

/// The event that says that nobody acknowledges, or somebody does again, and the remedy.
EventText describe_delivery(const DeliveryChanged& report, const Config& config);

/// Why the controller could not be reset, and the commands that do it.
std::string reset_not_permitted(const Config& config);
std::string reset_unavailable(const Config& config);

}  // namespace cansyncd
