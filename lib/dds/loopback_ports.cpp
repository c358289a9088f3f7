#include "dds/loopback_ports.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "system/descriptor.h"

namespace gateway::dds {
namespace {

/// FNV-1a; the same in every build, for programs of other builds look for the port too.
std::uint64_t hash_of(std::string_view text) noexcept {
  std::uint64_t hash = 14695981039346656037u;
  for (const char letter : text) hash = (hash ^ static_cast<unsigned char>(letter)) * 1099511628211u;
  return hash;
}

/// How often those tell of themselves that are not told of by others.
constexpr std::string_view kTellOften = "<SPDPInterval>500 ms</SPDPInterval>";

class Peers {
 public:
  void add(std::uint32_t port) {
    fmt::format_to(std::back_inserter(addresses_), "{}127.0.0.1:{}", addresses_.empty() ? "" : ",", port);
  }
  void add_places(std::uint32_t domain, std::string_view bus, std::uint32_t count) {
    for (std::uint32_t place = 0; place < count; ++place)
      add(serving_port(domain, index_of_place(bus, place)));
  }
  std::string text() const { return fmt::format("<Peers><Peer Address=\"{}\"/></Peers>", addresses_); }

 private:
  std::string addresses_;
};

/// One port for everything: the one beside it is of the other kind.
std::string ports(std::string_view index, std::uint32_t offset) {
  return fmt::format(
      "<ParticipantIndex>{0}</ParticipantIndex><MaxAutoParticipantIndex>{1}</MaxAutoParticipantIndex>"
      "<Ports><UnicastMetaOffset>{2}</UnicastMetaOffset><UnicastDataOffset>{2}</UnicastDataOffset></Ports>",
      index, kPlaces, offset);
}

constexpr std::uint32_t kServingOffset = serving_port(0, 0) - kFirstPort;

}  // namespace

std::uint32_t index_of_place(std::string_view bus, std::uint32_t place) noexcept {
  const std::uint64_t hash = hash_of(bus);
  // A step that has no divisor in common with the number of places leads through all of them.
  auto step = static_cast<std::uint32_t>((hash >> 32) % kPlaces);
  while (std::gcd(step, kPlaces) != 1) step = (step + 1) % kPlaces;
  return static_cast<std::uint32_t>((hash % kPlaces + std::uint64_t{place} * step) % kPlaces);
}

bool is_free(std::uint32_t port) noexcept {
  const sys::Descriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!probe.is_open()) return false;
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  // The socket interface takes every kind of address through this type.
  return ::bind(probe.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

std::string_view place_owner(std::span<const std::string> buses) noexcept {
  return buses.size() == 1 ? std::string_view(buses.front()) : std::string_view();
}

std::string serving_discovery(std::uint32_t domain, std::span<const std::string> buses, std::uint32_t place) {
  const std::string_view owner = place_owner(buses);
  const std::uint32_t asked = owner.empty() ? kSharedPlacesAsked : kPlacesAsked;
  Peers peers;
  // Another daemon of the same bus is in one of the places before this one, or asked here itself.
  peers.add_places(domain, owner, std::max(place + 1, asked));
  if (owner.empty()) {
    for (const std::string& bus : buses) peers.add_places(domain, bus, kPlacesAsked);
  } else {
    peers.add_places(domain, {}, kSharedPlacesAsked);
  }
  const bool easily_found = place < asked;
  for (std::uint32_t index = 0; index < kPlaces && !easily_found; ++index)
    peers.add(asking_port(domain, index));
  return fmt::format("{}{}{}", ports(fmt::to_string(index_of_place(owner, place)), kServingOffset),
                     easily_found ? "" : kTellOften, peers.text());
}

std::string asking_all_discovery(std::uint32_t domain) {
  Peers peers;
  for (std::uint32_t index = 0; index < kPlaces; ++index) peers.add(serving_port(domain, index));
  return fmt::format("{}{}{}", ports("auto", kServingOffset + 1), kTellOften, peers.text());
}

std::string asking_discovery(std::uint32_t domain, std::string_view bus) {
  Peers peers;
  peers.add_places(domain, bus, kPlacesAsked);
  peers.add_places(domain, {}, kSharedPlacesAsked);
  // A daemon that starts later does not know of the client.
  return fmt::format("{}{}{}", ports("auto", kServingOffset + 1), kTellOften, peers.text());
}

}  // namespace gateway::dds
