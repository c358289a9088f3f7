#pragma once

#include <span>
#include <string>
#include <vector>

#include "daemon/service/surroundings.h"
#include "daemon_config/daemon_config.h"
#include "dds/participant.h"

namespace cansyncd {

/// The DDS side of a bus, before anything else of DDS is made.
struct BusParticipant {
  gateway::dds::Participant participant;
  std::string taken_by;  ///< computer whose daemon has the name of the bus on the network; empty: none
};

/// Those of a process that serves these buses, in their order: buses of the same DDS options are one
/// participant on the network. `places`: where DDS is for each bus in the place of `dds.interface`; empty:
/// there.
///
/// A bus that a daemon of another computer serves is on `lo`, with `taken_by`. Throws
/// gateway::dds::SetupError for what cannot be had, and std::runtime_error when another daemon of this computer
/// serves one of the buses already, with its program, process and host; `dds.name_in_use` of a bus may allow
/// both. Looks for 0.3 s at most. Main thread.
std::vector<BusParticipant> bus_participants(std::span<const DaemonConfig* const> buses,
                                             std::span<const NetworkPlace> places = {});

/// The computer whose daemon has the name of one of these buses on the network of `place`; empty: none, or
/// a daemon of this computer. Buses that allow it (`dds.name_in_use`) are not looked for. Looks for 0.3 s at
/// most. Throws gateway::dds::SetupError. Main thread.
std::string name_taken_by(std::span<const DaemonConfig> buses, const NetworkPlace& place);

}  // namespace cansyncd
