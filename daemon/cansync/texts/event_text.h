#pragma once

#include <optional>

#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/desk/event_text.h"
#include "daemon/service/event_codes.h"

/// What the realtime thread reports, in words. Pure functions; not for the realtime thread (allocates).
namespace cansyncd {

/// The kind of a master's event.
EventCode code_of(cansync::MasterEvent::Code code);

/// The event that stands for `report`; nothing for reports that are no events (progress of a transfer), or
/// that are counted before they become one (refused reference values).
std::optional<EventText> describe(const Report& report, const Config& config);

}  // namespace cansyncd
