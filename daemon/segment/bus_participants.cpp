#include "daemon/segment/bus_participants.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <optional>
#include <stdexcept>
#include <utility>

#include "dds/other_daemons.h"

namespace cansyncd {
namespace {

/// Where DDS is for a bus.
gateway::dds::ParticipantOptions options_of(const DaemonConfig& bus, const NetworkPlace& place) {
  const DdsConfig& dds = bus.dds;
  gateway::dds::ParticipantOptions options{
      dds.domain, dds.partition, dds.interface, dds.xml, dds.security, true, dds.final_types, {}, {}};
  if (place.interface.empty()) return options;
  options.interface = place.interface;
  options.link = place.link;
  return options;
}

/// Is it a process of this computer? Several computers may have one name, but a process of its number that is
/// not this one is unlikely then.
bool runs_here(const gateway::dds::OtherDaemon& other) {
  std::array<char, 256> host = {};
  if (::gethostname(host.data(), host.size() - 1) != 0 || other.host != host.data()) return false;
  const auto process = static_cast<pid_t>(other.process);
  return process > 0 && process != ::getpid() && (::kill(process, 0) == 0 || errno == EPERM);
}

bool allows(const DaemonConfig& bus) {
  return bus.dds.name_in_use == NameInUse::event;
}

}  // namespace

std::vector<BusParticipant> bus_participants(std::span<const DaemonConfig* const> buses,
                                             std::span<const NetworkPlace> places) {
  std::vector<gateway::dds::ParticipantOptions> options;
  for (std::size_t i = 0; i < buses.size(); ++i)
    options.push_back(options_of(*buses[i], places.empty() ? NetworkPlace{} : places[i]));
  std::vector<gateway::dds::Participant> participants = gateway::dds::participants(std::move(options));
  std::vector<std::optional<gateway::dds::OtherDaemon>> others(buses.size());
  if (!std::all_of(buses.begin(), buses.end(), [](const DaemonConfig* bus) { return allows(*bus); }))
    others = gateway::dds::names_in_use(participants);
  std::vector<BusParticipant> all;
  for (std::size_t i = 0; i < buses.size(); ++i) {
    BusParticipant bus{std::move(participants[i]), {}};
    if (others[i] && !allows(*buses[i])) {
      const gateway::dds::ParticipantOptions& where = bus.participant.options();
      if (!where.xml.empty() || where.interface == "lo" || runs_here(*others[i])) {
        throw std::runtime_error(fmt::format(
            "bus {} is served already ({}): {}. Clients could not tell the two apart: stop that one, or give this "
            "one a bus.name (or dds.domain) of its own; dds.name_in_use = \"event\" starts it all the same",
            buses[i]->bus.name, bus.participant.place(), others[i]->name));
      }
      bus.taken_by = others[i]->host;
      bus.participant.move_to("lo", "");
    }
    all.push_back(std::move(bus));
  }
  return all;
}

std::string name_taken_by(std::span<const DaemonConfig> buses, const NetworkPlace& place) {
  std::vector<gateway::dds::Participant> looking;
  for (const DaemonConfig& bus : buses) {
    if (allows(bus)) continue;
    gateway::dds::ParticipantOptions options = options_of(bus, place);
    options.serves = false;
    looking.emplace_back(options);
  }
  for (const auto& other : gateway::dds::names_in_use(looking)) {
    if (other && !runs_here(*other)) return other->host;
  }
  return {};
}

}  // namespace cansyncd
