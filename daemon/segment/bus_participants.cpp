#include "daemon/segment/bus_participants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

#include "dds/other_daemons.h"

namespace cansyncd {

std::vector<gateway::dds::Participant> bus_participants(std::span<const DaemonConfig* const> buses) {
  std::vector<gateway::dds::ParticipantOptions> options;
  for (const DaemonConfig* bus : buses) {
    const DdsConfig& dds = bus->dds;
    options.push_back(
        {dds.domain, dds.partition, dds.interface, dds.xml, dds.security, true, dds.final_types, {}});
  }
  std::vector<gateway::dds::Participant> participants = gateway::dds::participants(std::move(options));
  const auto allowed = [](const DaemonConfig* bus) { return bus->dds.name_in_use == NameInUse::event; };
  if (std::all_of(buses.begin(), buses.end(), allowed)) return participants;
  const std::vector<std::string> others = gateway::dds::names_in_use(participants);
  for (std::size_t i = 0; i < buses.size(); ++i) {
    if (others[i].empty() || allowed(buses[i])) continue;
    throw std::runtime_error(fmt::format(
        "bus {} is served already ({}): {}. Clients could not tell the two apart: stop that one, or give this "
        "one a bus.name (or dds.domain) of its own; dds.name_in_use = \"event\" starts it all the same",
        buses[i]->bus.name, participants[i].place(), others[i]));
  }
  return participants;
}

}  // namespace cansyncd
