#include "daemon/cansync/segment/load_checked.h"

#include "cansync/sim/drive_faults.h"
#include "daemon/segment/segment_start.h"

namespace cansyncd {

ConfigFile load_checked(const std::string& path, std::span<const std::string> overrides) {
  return checked(load_config(path, overrides), sim::drive_faults());
}

}  // namespace cansyncd
