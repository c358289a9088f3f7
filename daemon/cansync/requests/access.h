#pragma once

#include <string>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/desk/access.h"

/// What requests of CANsync are allowed to do. Pure functions; any thread.
namespace cansyncd {

/// The right a request needs and whether it changes something, a row for each kind.
Effect effect_of(const Request& request);

/// The least right a request needs.
Right needed_right(const Request& request);

/// Would it change a drive, the line or the master? False for reads, uploads, cancelling and withdrawing.
bool changes_something(const Request& request);

/// Why `request` is not taken from a topic that gives only `right`; nothing when it may be taken.
gateway::dds::Problem right_refusal(const Request& request, Right right);

/// Why what only engineers may give is not taken from topic Command.
std::string not_on_topic_command();

/// Why `request` is not taken because the daemon is read-only; nothing when it may be taken.
gateway::dds::Problem read_only_refusal(const Request& request, const Config& config);

/// The same for reference values.
gateway::dds::Problem read_only_refusal_of_references(const Config& config);

}  // namespace cansyncd
