#include "daemon/desk/client_table.h"

#include <algorithm>
#include <utility>

namespace cansyncd {

bool LivingPlaces::look(std::span<const dds_entity_t> readers, PlaceFinder& finder, SteadyTime now) {
  std::vector<Seen> seen;
  for (const dds_entity_t reader : readers) {
    dds_subscription_matched_status_t status = {};
    (void)dds_get_subscription_matched_status(reader, &status);
    seen.push_back({reader, status.current_count, status.total_count});
  }
  if (now >= before_until_) before_.clear();
  if (seen == seen_) return false;
  const bool moved = !seen_.empty() && !seen.empty() && seen.front().reader != seen_.front().reader;
  if (moved) {
    before_.merge(places_);
    before_until_ = now + kFindAgain;
  }
  seen_ = std::move(seen);
  ++looks_;
  places_.clear();
  writers_.clear();
  for (std::size_t i = 0; i < readers.size(); ++i) {
    // One that is matched only now is found by the next look: the counts have changed then.
    std::vector<dds_instance_handle_t> writers(seen_[i].current);
    const dds_return_t found = dds_get_matched_publications(readers[i], writers.data(), writers.size());
    writers.resize(std::min(writers.size(), static_cast<std::size_t>(std::max(found, 0))));
    for (const auto writer : writers) places_.insert(finder.find(readers[i], writer));
    writers_.push_back(std::move(writers));
  }
  return true;
}

std::pair<ClientEntry*, ClientTable::Admission> ClientTable::enter(const ClientIdentity& identity,
                                                                   const Place& place,
                                                                   const std::string& who) {
  if (ClientEntry* known = find(identity)) {
    if (known->gone) return {nullptr, Admission::leaving};
    if (known->place != place) return {nullptr, Admission::foreign};
    return {known, Admission::admitted};
  }
  if (clients_.size() >= kClients) return {nullptr, Admission::full};
  ClientEntry& entry = clients_[identity];
  entry.place = place;
  entry.who = who;
  return {&entry, Admission::admitted};
}

ClientEntry* ClientTable::find(const ClientIdentity& identity) {
  const auto found = clients_.find(identity);
  return found == clients_.end() ? nullptr : &found->second;
}

std::vector<ClientIdentity> ClientTable::mark_gone(const LivingPlaces& living) {
  std::vector<ClientIdentity> gone;
  for (auto& [identity, client] : clients_) {
    if (client.gone || living.has(client.place)) continue;
    client.gone = true;
    gone.push_back(identity);
  }
  return gone;
}

}  // namespace cansyncd
