#pragma once

#include <span>
#include <string>

#include "config/settings.h"
#include "daemon/cansync_slave/config/config.h"
#include "daemon/options/loaded_file.h"

namespace cansyncd {

using SlaveRoleFile = LoadedFile<SlaveRoleConfig>;

/// Reads and checks `path`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
SlaveRoleFile load_slave_config(const std::string& path, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
SlaveRoleFile build_slave_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
