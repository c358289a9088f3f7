#pragma once

#include <span>
#include <vector>

#include "daemon/config/daemon_config.h"
#include "dds/participant.h"

namespace cansyncd {

/// The DDS participants of a process that serves these buses, in their order, before anything else of DDS is
/// made: buses of the same DDS options share one. Throws gateway::dds::SetupError for what cannot be had, and
/// std::runtime_error when another daemon serves one of the buses already, with its program, process and
/// host, unless `dds.name_in_use` of that bus allows it. Looks for 0.3 s at most. Main thread.
std::vector<gateway::dds::Participant> bus_participants(std::span<const DaemonConfig* const> buses);

}  // namespace cansyncd
