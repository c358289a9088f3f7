#pragma once

#include <span>
#include <string>

#include "config/settings.h"
#include "daemon_config/loaded_file.h"
#include "j1939/config/config.h"

namespace cansyncd {

using J1939File = LoadedFile<J1939Config>;

/// Reads and checks `source`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
J1939File load_j1939_config(const config::Source& source, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
J1939File build_j1939_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
