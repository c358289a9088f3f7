#pragma once

#include <string>
#include <vector>

#include "cansync/config/file.h"

namespace cansyncd {

/// What a reload does.
struct ConfigReload {
  ConfigFile merged;                 ///< the running configuration with all changes that are possible now
  std::vector<std::string> applied;  ///< options that changed and take effect, e.g. "slave.3.name"
  std::vector<std::string> needs_restart;  ///< options that changed and keep their running value
  /// The running configuration with those changes, too, for which the line has to be set up anew; with
  /// problems when they make no sense.
  ConfigFile anew;
  std::vector<std::string> needs_set_up;  ///< options of `needs_restart` that take effect then
};

/// Compares the running configuration with a newly read one that has no problems. `merged` has problems when
/// the changes make no sense without those that need a restart; nothing is to be applied then. Main thread.
ConfigReload plan_reload(const ConfigFile& running, const ConfigFile& wanted);

}  // namespace cansyncd
