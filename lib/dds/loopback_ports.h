#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

/// Who listens where on this computer, so that a program finds the daemon of its bus without meeting all
/// others. A domain has 250 UDP ports; those that DDSI calls discovery ports of unicast belong to programs
/// that serve, the ones between them to those that only ask. Which of its ports a daemon takes follows from
/// the name of its bus: it takes the first free one of an order that the name decides, and who asks for that
/// bus looks at the first few of it alone. A daemon of several buses can be in one place only: it takes one
/// of the order of no name, at whose beginning everybody looks, too. Programs of others, which know nothing
/// of this, look at all ports of those that serve.
namespace gateway::dds {

/// Ports of a domain: 250 from 7400 + 250 * domain on.
inline constexpr std::uint32_t kFirstPort = 7400;
inline constexpr std::uint32_t kPortsOfDomain = 250;
/// Where a daemon may be, and most clients of a domain.
inline constexpr std::uint32_t kPlaces = 120;
/// So many of them a client looks at. A daemon that found them all taken tells every port of clients.
inline constexpr std::uint32_t kPlacesAsked = 6;
/// So many places of daemons of several buses everybody looks at.
inline constexpr std::uint32_t kSharedPlacesAsked = 3;

/// Participant index, 0..kPlaces - 1, of the `place`th choice (0 and more, below kPlaces) of a bus; without a
/// name, of a daemon that serves several.
std::uint32_t index_of_place(std::string_view bus, std::uint32_t place) noexcept;

/// UDP port of a daemon with this index.
constexpr std::uint32_t serving_port(std::uint32_t domain, std::uint32_t index) noexcept {
  return kFirstPort + kPortsOfDomain * domain + 10 + 2 * index;
}
/// UDP port of the client with this index.
constexpr std::uint32_t asking_port(std::uint32_t domain, std::uint32_t index) noexcept {
  return serving_port(domain, index) + 1;
}

/// Nobody listens at the UDP port now.
bool is_free(std::uint32_t port) noexcept;

/// What Cyclone's <Discovery> is told for a daemon in a place of its bus, without the element itself.
/// `buses`: those it serves, at least one.
std::string serving_discovery(std::uint32_t domain, std::span<const std::string> buses, std::uint32_t place);
/// Whose order of places a daemon of these buses follows.
std::string_view place_owner(std::span<const std::string> buses) noexcept;
/// The same for a client.
std::string asking_discovery(std::uint32_t domain, std::string_view bus);
/// The same for a client that looks for the daemons of every bus.
std::string asking_all_discovery(std::uint32_t domain);

}  // namespace gateway::dds
