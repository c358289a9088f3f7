#pragma once

#include "cansync/cluster/cluster.h"
#include "cansync/config/config.h"
#include "cansync_slave/config/config.h"

namespace cansyncd {

/// The whole configuration of a cluster: plain values. `file.h` reads it from a TOML file.
struct ClusterConfig {
  DaemonConfig daemon;  ///< what both buses have: name without a level, realtime thread, DDS
  SlaveRoleConfig upper;
  Config lower;
  cansync::ClusterSettings cluster;  ///< with the settings of both
};

}  // namespace cansyncd
