#pragma once

#include <cstdint>

#include "cansync/settings/settings.h"
#include "daemon/desk/fair_lanes.h"

namespace cansyncd {

/// What a request competes for. A lane is a queue of the master: all jobs of a kind for one slave (broadcast:
/// of one priority; line: the one lane of everything that takes effect at once).
enum class LaneKind : std::uint8_t { parameter, transfer, control_word, broadcast, line };

/// The limits that keep every queue of the master from filling up: few jobs of a lane, so that nobody waits
/// behind many of another client, but enough that the slave need not wait for the gateway's thread.
LaneLimits lane_limits(const cansync::CommandChannelSettings& settings);

}  // namespace cansyncd
