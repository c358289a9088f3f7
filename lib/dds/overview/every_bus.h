#pragma once

#include <chrono>
#include <vector>

#include "dds/daemon_sight.h"
#include "gateway.h"

namespace gateway::dds {

/// The daemons of all buses in a domain, by bus, as each told last. Waits `options.wait` for them, or until
/// `stop`; a daemon that was killed less than 5 s ago may be among them. `options.bus` does not matter, but
/// with DDS Security only what its identity may see is found. Throws SetupError.
std::vector<gateway_GatewayStatus> daemons_of_every_bus(const ClientOptions& options);

}  // namespace gateway::dds
