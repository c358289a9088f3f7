#pragma once

#include <span>
#include <string>

#include "config/settings.h"
#include "daemon_config/loaded_file.h"
#include "layer2/config/config.h"

namespace cansyncd {

/// The file of a bus of general frames.
using Layer2File = LoadedFile<Layer2Config>;

/// Reads and checks `source`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
Layer2File load_layer2_config(const config::Source& source, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
Layer2File build_layer2_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
