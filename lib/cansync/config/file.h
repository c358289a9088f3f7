#pragma once

#include <optional>
#include <span>
#include <string>

#include "cansync/config/draft.h"
#include "daemon_config/loaded_file.h"

namespace cansyncd {

using ConfigFile = LoadedFile<Config>;

/// Reads and checks `source`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
ConfigFile load_config(const config::Source& source, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
ConfigFile build_config(Settings settings, const std::string& path);

/// The slave number of an option of [[slave]] and below it; nothing for any other.
std::optional<unsigned> slave_of(const Setting& setting);

}  // namespace cansyncd
