#pragma once

#include <dds/dds.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "daemon/desk/request_numbers.h"

namespace cansyncd {

/// What is known of a client while it lives, and until its last request is answered.
struct ClientEntry {
  Place place = {};                ///< participant its requests come from
  std::string name;                ///< that it gave itself; empty: none yet
  std::string who;                 ///< for messages
  unsigned open = 0;               ///< requests that are not answered
  std::size_t transfer_bytes = 0;  ///< data of its open transfers
  RequestNumbers numbers;
  std::deque<std::pair<std::uint64_t, SteadyTime>> early_cancels;  ///< of requests that have not come yet
  bool gone = false;
};

/// The participants that have a request writer matched with one of our readers. When DDS was moved to another
/// network, those of before count for a while yet: they find the new readers one by one. Gateway thread only.
class LivingPlaces {
 public:
  /// For so long those count that were there before DDS was moved: longer than a lease.
  static constexpr std::chrono::seconds kFindAgain{10};

  /// Looks again when a writer of one of `readers` came or went since the last call (the first call looks
  /// always). Returns whether it looked.
  bool look(std::span<const dds_entity_t> readers, PlaceFinder& finder, SteadyTime now);
  bool has(const Place& place) const { return places_.contains(place) || before_.contains(place); }
  const std::set<Place>& all() const noexcept { return places_; }
  /// How often it looked.
  std::uint64_t looks() const noexcept { return looks_; }
  /// The writers matched with reader `index` when it looked.
  std::span<const dds_instance_handle_t> writers(std::size_t index) const { return writers_.at(index); }

 private:
  struct Seen {
    dds_entity_t reader = 0;
    std::uint32_t current = 0;
    std::uint32_t total = 0;
    friend bool operator==(const Seen&, const Seen&) = default;
  };
  std::vector<Seen> seen_;
  std::vector<std::vector<dds_instance_handle_t>> writers_;  ///< by reader
  std::set<Place> places_;
  std::set<Place> before_;  ///< those of before a move
  SteadyTime before_until_;
  std::uint64_t looks_ = 0;
};

/// The clients, by identity. An identity belongs to the participant that used it first, for as long as that
/// one lives. Bounded. Gateway thread only.
class ClientTable {
 public:
  /// Most clients at a time.
  static constexpr std::size_t kClients = 256;

  enum class Admission : std::uint8_t {
    admitted,
    foreign,  ///< the identity belongs to another participant
    leaving,  ///< that participant is gone, but its requests are not all cancelled yet
    full,     ///< there are `kClients` already
  };

  /// The client with this identity, entered if it is new; null unless admitted. Valid until it is erased.
  std::pair<ClientEntry*, Admission> enter(const ClientIdentity& identity, const Place& place,
                                           const std::string& who);
  ClientEntry* find(const ClientIdentity& identity);
  void erase(const ClientIdentity& identity) { clients_.erase(identity); }
  std::size_t size() const noexcept { return clients_.size(); }
  /// Calls `use(client)` for each.
  template <class Use>
  void each(Use&& use) const {
    for (const auto& entry : clients_) use(entry.second);
  }

  /// Marks the clients whose participant no longer lives, and returns those that were not marked before.
  std::vector<ClientIdentity> mark_gone(const LivingPlaces& living);

 private:
  std::map<ClientIdentity, ClientEntry> clients_;
};

}  // namespace cansyncd
