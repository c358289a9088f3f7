#pragma once

#include <string>
#include <string_view>

#include "can/bus.h"
#include "daemon/config.h"
#include "daemon/event_text.h"
#include "daemon/exchange.h"

/// State and faults of the bus in words. Pure functions; not for the realtime thread (they allocate).
namespace cansyncd {

/// Name of a controller state as MasterStatus tells it, e.g. "bus-off".
std::string_view name(can::ControllerState state) noexcept;
/// Name of an interface's state as MasterStatus tells it, e.g. "wrong-bit-rate".
std::string_view name(can::LinkState state) noexcept;
/// Name of a source of time stamps as MasterStatus tells it, e.g. "kernel".
std::string_view name(can::TimestampSource source) noexcept;

/// Fills what MasterStatus tells of interface, controller and their counters.
void fill_bus(const MasterSnapshot& master, const can::LinkFacts& link, cansync_MasterStatus& out);

/// The event that stands for a change of the interface: what happened, why nothing is sent, and the remedy.
EventText describe_link(const LinkChanged& report, const Config& config);

/// The event that stands for a fault that began or is over.
EventText describe_fault(const BusFault& report);

/// Why the controller could not be reset, and the commands that do it.
std::string reset_not_permitted(const Config& config);
std::string reset_unavailable(const Config& config);

}  // namespace cansyncd
