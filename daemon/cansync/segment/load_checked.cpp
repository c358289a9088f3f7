#include "daemon/cansync/segment/load_checked.h"

#include "cansync/sim/drive_faults.h"
#include "daemon/segment/segment_start.h"

namespace cansyncd {

ConfigFile load_checked(const config::Source& source, std::span<const std::string> overrides) {
  return checked(load_config(source, overrides), sim::drive_faults());
}

}  // namespace cansyncd
