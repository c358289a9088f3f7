#pragma once

#include "cli/base/interrupt.h"
#include "cli/base/session.h"
#include "dds/daemon_sight.h"

namespace cansync::cli {

/// How a session's daemon is found by the client libraries of other protocols than the master's.
gateway::dds::ClientOptions bus_options(Session& session);

/// A connection of such a library. Throws client::NoDaemon, client::SetupError, Interrupted,
/// ArgumentsAreRight.
template <class Client>
Client connect_bus(Session& session) {
  session.expect_input("");  // a batch that only checks its lines goes no further
  try {
    return Client(bus_options(session));
  } catch (const gateway::dds::NoDaemon& error) {
    if (interrupt_flag().load()) throw Interrupted();
    throw client::NoDaemon(error.what());
  } catch (const gateway::dds::SetupError& error) {
    throw client::SetupError(error.what());
  }
}

}  // namespace cansync::cli
