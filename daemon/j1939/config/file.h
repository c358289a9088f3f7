#pragma once

#include <span>
#include <string>
#include <vector>

#include "config/problem.h"
#include "config/settings.h"
#include "daemon/j1939/config/config.h"

namespace cansyncd {

/// A configuration as read, together with where it came from.
struct J1939File {
  std::string path;
  J1939Config config;                     ///< only to be used when there are no problems
  std::vector<config::Setting> settings;  ///< what was given, by the file or --set
  std::vector<config::Problem> problems;  ///< everything found wrong, in the order of the file
};

/// Reads and checks `path`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
J1939File load_j1939_config(const std::string& path, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
J1939File build_j1939_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
