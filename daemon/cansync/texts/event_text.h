#pragma once

#include <optional>
#include <string>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/desk/event_text.h"
#include "daemon/service/event_codes.h"

/// What the realtime thread reports, in words. Pure functions; not for the realtime thread (allocates).
namespace cansyncd {

/// The kind of a master's event.
EventCode code_of(cansync::MasterEvent::Code code);

/// Why a slave is in state `held`, with what was found and expected; empty when it is not. At most 250 bytes.
std::string held_reason(const cansync::SlaveStatus& status, const Config& config);

/// The event that stands for `report`; nothing for reports that are no events (progress of a transfer), or
/// that are counted before they become one (refused reference values). `link`: the interface as it was found
/// last.
std::optional<EventText> describe(const Report& report, const Config& config,
                                  const can::LinkFacts& link = {});

}  // namespace cansyncd
