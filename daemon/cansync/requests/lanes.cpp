#include "daemon/cansync/requests/lanes.h"

#include <algorithm>
#include <limits>

namespace cansyncd {

LaneLimits lane_limits(const cansync::CommandChannelSettings& settings) {
  // A parameter takes at least one interval: four last until the gateway's thread has given the next.
  constexpr unsigned kAhead = 4;
  constexpr unsigned kAny = std::numeric_limits<unsigned>::max();
  const auto at_most = [](unsigned wanted, unsigned queue) { return std::clamp(queue, 1u, wanted); };
  // In the order of `LaneKind`. A transfer is long: the next is begun when it has ended.
  return {{kAhead, at_most(kAny, settings.parameter_queue)},
          {1, at_most(kAny, settings.transfer_queue)},
          {kAhead, kAny},
          {at_most(kAhead, settings.broadcast_queue), kAny},
          {kAhead, kAny}};
}

}  // namespace cansyncd
