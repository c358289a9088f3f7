#include "daemon/cansync/config/reload.h"

#include <utility>

#include "config/reload.h"

namespace cansyncd {

ConfigReload plan_reload(const ConfigFile& running, const ConfigFile& wanted) {
  // What a slave, that only one of the two files has, gives does not take effect: the set of slaves needs a
  // restart.
  config::Changes changes = config::compare(running.settings, wanted.settings, [&](const Setting& setting) {
    const std::optional<unsigned> slave = slave_of(setting);
    return !slave || (running.config.master.slaves[*slave].configured &&
                      wanted.config.master.slaves[*slave].configured);
  });
  return {build_config(std::move(changes.merged), wanted.path), std::move(changes.applied),
          std::move(changes.needs_restart)};
}

}  // namespace cansyncd
