#pragma once

#include <optional>

#include "cansync_slave/config/config.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/event_text.h"

namespace cansyncd {

/// The event that stands for a report of the realtime thread; nothing for values and actions, which have
/// topics of their own. Allocates; not for the realtime thread.
std::optional<EventText> event_of(const SlaveSideReport& report, const SlaveRoleConfig& config);

}  // namespace cansyncd
