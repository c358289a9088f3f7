#pragma once

#include <span>

#include "daemon/config/draft.h"

/// The daemon's own rows of options.
namespace cansyncd::rows {

std::span<const Row> daemon_options();   ///< bus, realtime, recorder, dds, sim
std::span<const Row> access_options();   ///< access
std::span<const Row> metrics_options();  ///< metrics
std::span<const Row> sync_options();     ///< sync

}  // namespace cansyncd::rows
