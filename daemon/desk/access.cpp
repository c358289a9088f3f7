#include "daemon/desk/access.h"

namespace cansyncd {

gateway::dds::Problem read_only_refusal(const Effect& effect, bool read_only) {
  if (!read_only || !effect.changes) return std::nullopt;
  return gateway::dds::Denial{
      gateway_CAUSE_READ_ONLY,
      "access.read_only: this daemon only looks on; it takes no request that would change a drive or the "
      "line, reads and uploads are allowed; set it to false in the configuration and reload the daemon "
      "(SIGHUP)"};
}

}  // namespace cansyncd
