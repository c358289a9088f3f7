#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/desk/audit.h"
#include "daemon/desk/client_table.h"
#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_replies.h"
#include "dds/daemon_identity.h"
#include "dds/denial.h"
#include "dds/request_key.h"
#include "dds/topic.h"

namespace cansyncd {

/// Who gave a request, in words. `name`: what the client calls itself.
Requester who_of(std::string_view name, const gateway::dds::RequestKey& key, const Place& place);

/// Which requests are open, by client and number, and what all of a client's together may take. Knows nothing
/// of what they ask for. Gateway thread only.
class JobBook {
 public:
  /// Numbers of jobs are counted from one that this start has for itself: a number that was read before a
  /// restart is no job of this start.
  explicit JobBook(const gateway::dds::DaemonIdentity& daemon) noexcept : next_id_(first_id(daemon)) {}

  /// Most open requests of one client: no client can take the queues from the others.
  static constexpr unsigned kPerClient = gateway::dds::kOpenRequests;
  /// Most bytes of all open transfers together, and of those of one client.
  static constexpr std::size_t kTransferMemory = 128u << 20;
  static constexpr std::size_t kClientTransferMemory = 32u << 20;
  /// Most cancels of one client that are remembered until their request comes.
  static constexpr std::size_t kEarlyCancels = 64;
  /// A cancel may overtake its request on the way; it is remembered so long.
  static constexpr std::chrono::seconds kEarlyCancel{10};

  /// Whether a request may be looked at.
  struct Admission {
    ClientEntry* client = nullptr;  ///< null: it may not
    gateway::dds::Denial denial = {};
    bool forget = false;  ///< nothing is kept of its client once it was answered
  };

  /// Uses the number of a request whose client `ClientTable::enter` has given, and not as foreign. `written`
  /// and `now`: CLOCK_REALTIME, ns; `max_age`: 0 = any.
  Admission admit(const gateway::dds::RequestKey& key,
                  const std::pair<ClientEntry*, ClientTable::Admission>& entered, std::int64_t written,
                  std::int64_t now, std::chrono::milliseconds max_age);

  /// Why the client cannot have one more request with `bytes` of data; nothing when it can.
  gateway::dds::Problem no_room(const ClientEntry& client, std::size_t bytes) const;

  /// The first number of a start: 2^40..2^41 - 1, by the random bytes of its identity. Below 2^53, which JSON
  /// and scripts hold as a whole number.
  static JobId first_id(const gateway::dds::DaemonIdentity& daemon) noexcept;

  /// A number that no request had before.
  JobId next_id() noexcept { return next_id_++; }

  /// Request `id` of a client that was admitted is open, with `bytes` of data.
  void open(const gateway::dds::RequestKey& key, JobId id, std::size_t bytes);
  /// It was answered. True: that was the last of a client that is gone.
  bool close(const gateway::dds::RequestKey& key, std::size_t bytes);
  /// Of its data, `bytes` are kept no longer.
  void let_go(const gateway::dds::RequestKey& key, std::size_t bytes);
  /// All were answered.
  void close_all();

  /// The open request of this client and number.
  std::optional<JobId> find(const gateway::dds::RequestKey& key) const;
  /// Bytes of data of all open requests.
  std::size_t bytes() const noexcept { return bytes_; }

  /// A cancel came before its request, or after its end.
  static void remember_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now);
  /// True when a cancel of the request came before it; takes it out.
  static bool take_early_cancel(ClientEntry& client, std::uint64_t request, SteadyTime now);

  ClientTable& clients() noexcept { return clients_; }
  const ClientTable& clients() const noexcept { return clients_; }

 private:
  using Key = std::pair<ClientIdentity, std::uint64_t>;

  ClientTable clients_;
  std::map<Key, JobId> open_;  ///< requests of clients that are not answered
  std::size_t bytes_ = 0;
  JobId next_id_;
};

}  // namespace cansyncd
