#pragma once

#include <cansync/client.h>

#include <algorithm>
#include <chrono>

#include "client/src/set_up.h"
#include "dds/ask/daemon_sight.h"
#include "dds/overview/every_bus.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// A program's options as the clients of other protocols than the master want them.
inline gateway::dds::ClientOptions client_options(const Options& options) {
  return {.domain = options.domain,
          .bus = options.bus,
          .interface = options.interface,
          .client_name = options.client_name,
          .xml = options.xml,
          .security = options.security,
          .final_types = options.final_types,
          .wait = options.wait,
          .go_on = options.go_on};
}

/// How long the first status is waited for: it is kept for whoever comes.
inline std::chrono::milliseconds first_status_wait(const Options& options) {
  return std::max(std::chrono::milliseconds(2000), options.wait);
}

/// The same options with the only bus of the domain when they name none. Throws NoDaemon when there is none, or several;
/// SetupError.
inline Options with_bus(Options options) {
  if (!options.bus.empty()) return options;
  try {
    options.bus = set_up([&] { return gateway::dds::only_bus(client_options(options)); });
  } catch (const gateway::dds::NoDaemon& error) {
    throw NoDaemon(error.what());
  }
  return options;
}

/// A client of a protocol, made of its options and `more`, with the errors that programs know.
template <class ProtocolClient, class... More>
ProtocolClient connect_to(const Options& options, More... more) {
  const Options named = with_bus(options);
  try {
    return set_up([&] { return ProtocolClient(client_options(named), more...); });
  } catch (const gateway::dds::OtherProtocol& error) {
    throw OtherProtocol(error.bus, error.served_as, error.needs);
  } catch (const gateway::dds::NoDaemon& error) {
    throw NoDaemon(error.what());
  }
}

}  // namespace cansync::client::detail
