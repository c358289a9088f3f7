#pragma once

#include <cansync/client.h>

#include <algorithm>
#include <chrono>

#include "client/src/set_up.h"
#include "dds/daemon_sight.h"

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
          .wait = options.wait};
}

/// How long the first status is waited for: it is kept for whoever comes.
inline std::chrono::milliseconds first_status_wait(const Options& options) {
  return std::max(std::chrono::milliseconds(2000), options.wait);
}

/// A client of a protocol, made of its options and `more`, with the errors that programs know.
template <class ProtocolClient, class... More>
ProtocolClient connect_to(const Options& options, More... more) {
  try {
    return set_up([&] { return ProtocolClient(client_options(options), more...); });
  } catch (const gateway::dds::NoDaemon& error) {
    throw NoDaemon(error.what());
  }
}

}  // namespace cansync::client::detail
