#pragma once

#include <optional>
#include <string>

#include "cansync/config/config.h"

namespace cansyncd {

/// What is wrong with `sync.can_identifier`: CANsync uses it itself. Nothing: no software SYNC frame is on
/// the bus, or it has an identifier of its own. Main thread.
std::optional<std::string> wrong_sync_identifier(const SyncConfig& sync);

/// A line for `--check` of a configuration that is allowed and will probably not work: it shall run on a CAN
/// interface, and the computer neither makes SYNC nor follows it, so no drive can lock. Empty: nothing to
/// warn of. Main thread.
std::string sync_warning(const Config& config);

}  // namespace cansyncd
