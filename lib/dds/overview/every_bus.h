#pragma once

#include <functional>
#include <string>
#include <vector>

#include "dds/ask/daemon_sight.h"
#include "gateway.h"

namespace gateway::dds {

/// The daemons of all buses in a domain, by bus, as each told last. Waits `options.wait` for them, or until
/// `stop`; a daemon that was killed less than 5 s ago may be among them. `options.bus` does not matter, but
/// with DDS Security only what its identity may see is found. Throws SetupError.
std::vector<gateway_GatewayStatus> daemons_of_every_bus(const ClientOptions& options);

/// More than one bus is served where a program that names none looks; the text names them.
class SeveralBuses : public NoDaemon {
 public:
  using NoDaemon::NoDaemon;
};

/// The only bus that is served in the domain and on the interface of `options`; its `bus` does not matter. Waits at most
/// `options.wait` for the first daemon, then until no other bus has been found for 500 ms: discovery takes some 100 ms.
/// Throws NoDaemon when no bus is found or the options ended the search, SeveralBuses, SetupError.
std::string only_bus(const ClientOptions& options);

}  // namespace gateway::dds
