#pragma once

#include <span>
#include <string>
#include <vector>

#include "cansync/config/file.h"
#include "cansync_cluster/config/config.h"
#include "cansync_slave/config/file.h"
#include "config/problem.h"
#include "config/settings.h"

namespace cansyncd {

/// A configuration as read, together with where it came from.
struct ClusterFile {
  std::string path;
  ClusterConfig config;                          ///< only to be used when there are no problems
  std::vector<config::Setting> settings;         ///< what was given without a level
  SlaveRoleFile upper;                           ///< that level's part, as the file of a slave
  ConfigFile lower;                              ///< that level's part, as the file of a master
  std::vector<config::Problem> problems;         ///< everything found wrong, in the order of the file
  std::vector<config::Problem> script_problems;  ///< of the fault scripts of both levels, as `LoadedFile`
};

/// Reads and checks `source`; `overrides` are "KEY=VALUE" and win over the file. Never throws for a wrong file:
/// all of its problems are in the result. Main thread.
ClusterFile load_cluster_config(const config::Source& source, std::span<const std::string> overrides);

}  // namespace cansyncd
