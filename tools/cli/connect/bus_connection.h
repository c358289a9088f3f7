#pragma once

#include "cli/base/session.h"
#include "dds/ask/daemon_sight.h"

namespace cansync::cli {

/// Where a session looks for daemons of any bus.
gateway::dds::ClientOptions domain_options(Session& session);

/// How a session's daemon is found by the client libraries of other protocols than the master's. Throws as `Session::bus`.
gateway::dds::ClientOptions bus_options(Session& session);

/// A connection of such a library, looked for as long as `--retry` says. Throws client::NoDaemon, client::SetupError,
/// Interrupted, ArgumentsAreRight.
template <class Client>
Client connect_bus(Session& session) {
  session.expect_input("");  // a batch that only checks its lines goes no further
  while (true) {
    try {
      return Client(bus_options(session));
    } catch (const gateway::dds::OtherProtocol& error) {
      throw client::NoDaemon(other_protocol_text(
          session.globals(), client::OtherProtocol(error.bus, error.served_as, error.needs)));
    } catch (const gateway::dds::NoDaemon& error) {
      if (!session.try_again(error.what())) throw client::NoDaemon(error.what());
    } catch (const client::NoDaemon& error) {  // no bus was named, and none is there
      if (!session.try_again(error.what())) throw;
    } catch (const gateway::dds::SetupError& error) {
      throw client::SetupError(error.what());
    }
  }
}

}  // namespace cansync::cli
