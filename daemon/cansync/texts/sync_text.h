#pragma once

#include "daemon/cansync/texts/event_text.h"

/// What is told of the SYNC line, in words. Pure functions; not for the realtime thread (they allocate).
namespace cansyncd {

/// The event that stands for a change between the timeline and what it follows.
EventText sync_event(const SyncSourceChanged& report, const Config& config);

/// The event that stands for a device that fails or works again, with the remedy.
EventText sync_event(const SyncDeviceChanged& report, const Config& config);

}  // namespace cansyncd
