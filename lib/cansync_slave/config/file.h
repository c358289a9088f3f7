#pragma once

#include <span>
#include <string>

#include "cansync_slave/config/config.h"
#include "config/settings.h"
#include "daemon_config/loaded_file.h"

namespace cansyncd {

using SlaveRoleFile = LoadedFile<SlaveRoleConfig>;

/// Reads and checks `source`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
SlaveRoleFile load_slave_config(const config::Source& source, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
SlaveRoleFile build_slave_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
