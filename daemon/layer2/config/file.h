#pragma once

#include <span>
#include <string>
#include <vector>

#include "config/problem.h"
#include "config/settings.h"
#include "daemon/layer2/config/config.h"

namespace cansyncd {

/// A configuration as read, together with where it came from.
struct Layer2File {
  std::string path;
  Layer2Config config;                    ///< only to be used when there are no problems
  std::vector<config::Setting> settings;  ///< what was given, by the file or --set
  std::vector<config::Problem> problems;  ///< everything found wrong, in the order of the file
};

/// Reads and checks `path`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
Layer2File load_layer2_config(const std::string& path, std::span<const std::string> overrides);

/// The same for settings that are already there; `path` names the file in problems.
Layer2File build_layer2_config(config::Settings settings, const std::string& path);

}  // namespace cansyncd
