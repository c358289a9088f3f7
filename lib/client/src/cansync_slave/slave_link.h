#pragma once

#include <cansync/client.h>

#include "cansync_slave/client/slave_client.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// Waits for the daemon that is the slave; only what is new is given. Throws NoDaemon and SetupError, as
/// programs know them.
cansync_slave::client::SlaveClient connect_to_slave(const Options& options);

}  // namespace cansync::client::detail
