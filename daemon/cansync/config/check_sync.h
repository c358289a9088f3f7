#pragma once

#include <optional>
#include <string>

#include "daemon/config/daemon_config.h"

namespace cansyncd {

/// What is wrong with `sync.can_identifier`: CANsync uses it itself. Nothing: no software SYNC frame is on
/// the bus, or it has an identifier of its own. Main thread.
std::optional<std::string> wrong_sync_identifier(const SyncConfig& sync);

}  // namespace cansyncd
