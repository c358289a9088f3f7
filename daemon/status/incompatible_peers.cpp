#include "daemon/status/incompatible_peers.h"

#include <fmt/format.h>

#include <map>
#include <vector>

#include "dds/incompatible.h"

namespace cansyncd {
namespace {

using gateway::dds::Incompatible;

/// The endpoints of one program that do not fit for the same reason.
struct Peer {
  const Incompatible* first = nullptr;
  std::size_t endpoints = 0;
};

std::string text_of(const Peer& peer) {
  std::string text = to_string(*peer.first);
  if (peer.endpoints > 1) text += fmt::format("; {} more of it likewise", peer.endpoints - 1);
  return text;
}

}  // namespace

std::optional<SteadyTime> IncompatiblePeers::step(SteadyTime now) {
  if (const std::uint64_t mismatches = participant_.mismatches(); mismatches != seen_) {
    seen_ = mismatches;
    // Not put off by those that go on coming.
    if (!due_ || *due_ > now + kSettle) due_ = now + kSettle;
  }
  if (due_ && now >= *due_) look(now);
  return due_;
}

void IncompatiblePeers::look(SteadyTime now) {
  const std::uint64_t types = participant_.type_mismatches();
  const std::vector<Incompatible> found =
      find_incompatible(participant_, types_differ_ || types != types_seen_, kMost);
  types_seen_ = types;
  types_differ_ = false;
  std::map<std::pair<std::string, std::string>, Peer> peers;
  std::set<std::string> programs;
  for (const Incompatible& endpoint : found) {
    Peer& peer = peers[{endpoint.participant, endpoint.policy}];
    if (peer.first == nullptr) peer.first = &endpoint;
    ++peer.endpoints;
    programs.insert(endpoint.participant);
    types_differ_ = types_differ_ || endpoint.policy == "type";
  }
  std::erase_if(told_, [&](const auto& known) { return !peers.contains(known); });
  for (const auto& [key, peer] : peers) {
    if (!told_.insert(key).second) continue;
    EventText event{gateway_SEVERITY_WARNING, "dds_incompatible", -1, text_of(peer), std::nullopt};
    event.client = peer.first->who;
    event.participant = key.first;
    events_.publish(event, now);
  }
  count_ = static_cast<std::uint32_t>(programs.size());
  due_ = found.empty() ? std::nullopt : std::optional(now + kAgain);
}

}  // namespace cansyncd
