#include "daemon/cansync/segment/load_checked.h"

#include "cansync/sim/drive_faults.h"
#include "daemon/segment/segment_start.h"

namespace cansyncd {

ConfigFile load_checked(const std::string& path, std::span<const std::string> overrides) {
  ConfigFile file = load_config(path, overrides);
  if (file.problems.empty()) {
    file.problems = check_surroundings(file.config, file.settings, path, sim::drive_faults());
  }
  return file;
}

}  // namespace cansyncd
