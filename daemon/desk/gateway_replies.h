#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <future>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "dds/denial.h"
#include "dds/endpoint.h"
#include "dds/reply_partition.h"
#include "dds/signal.h"

namespace cansyncd {

/// The DDS participant a request came from; all zero: not known.
using Place = std::array<std::uint8_t, 16>;

/// Finds the participant that wrote a sample. Gateway thread only.
class PlaceFinder {
 public:
  /// Participant of the writer `writer`, matched with `reader`; all zero when it has left already.
  Place find(dds_entity_t reader, dds_instance_handle_t writer);

 private:
  std::map<dds_instance_handle_t, Place> known_;
};

/// Ends writers whose reader has not acknowledged everything, each on a thread of its own: DDS waits up to a
/// second for that. The destructor waits for all. Gateway thread only.
class SlowEnds {
 public:
  /// Most that end at a time.
  static constexpr std::size_t kMost = 32;

  /// Takes `writer` (may be null) and ends it. False: too many are ending, and it is left where it is.
  template <class Writer>
  bool end(std::unique_ptr<Writer>&& writer) {
    std::erase_if(ending_, [](const std::future<void>& one) {
      return one.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    if (ending_.size() >= kMost) return false;
    // Should there be no thread for it, it ends here.
    std::shared_ptr<Writer> last = std::move(writer);
    try {
      ending_.push_back(std::async(std::launch::async, [last = std::move(last)]() mutable { last.reset(); }));
    } catch (const std::system_error&) {
    }
    return true;
  }

 private:
  std::vector<std::future<void>> ending_;
};

/// Most that is kept of one reply topic.
struct ReplyLimits {
  /// Clients with a writer: those that are known, and some that are refused. For one more, the one that was
  /// idle longest gives its writer up.
  std::size_t clients = 320;
  /// Replies that wait; then the oldest of the client with the most is dropped.
  std::size_t waiting = 32768;
  /// Those of one participant; more are dropped. Many more than DDS and the kernel keep of its requests ahead
  /// of its acknowledgements.
  unsigned waiting_per_place = 4096;
  /// Bytes of data that wait; then the oldest reply of the client with the most is dropped.
  std::size_t waiting_data = 128u << 20;
  /// Bytes that one client has not acknowledged; then its next replies wait.
  std::size_t under_way_each = 32u << 20;
  /// Bytes that all together have not acknowledged; then those lose theirs that have stood still for
  /// `patience`.
  std::size_t under_way = 128u << 20;
  std::chrono::milliseconds patience{5000};
};

/// One reply topic: each client has a writer of its own, in its own partition (dds/reply_partition.h), made
/// with the first reply and given up when the client is gone. So replies reach nobody else, and a client that
/// stands still, is slow or dead holds up nobody else. A reply that cannot be written now waits and is
/// written later: while the client's reader is not matched yet (DDS finds readers and writers of a client one
/// by one, so a request may be here before its client's reply reader is known), and while DDS waits for the
/// reader to acknowledge earlier ones. A write hardly blocks: while this thread waits it takes no requests,
/// and DDS handles no acknowledgement while a reader of requests is full. Gateway thread only.
template <class Reply>
class ReplyOutbox {
 public:
  /// A reply waits so long for its client's reader, and a client that is gone for it to acknowledge.
  static constexpr std::chrono::seconds kMatchTime{2};
  /// Between looks for readers, and after a write that timed out: so long at first, longer each time.
  static constexpr std::chrono::milliseconds kPause{10};
  static constexpr std::chrono::milliseconds kLongestPause{320};

  /// Throws gateway::dds::SetupError. `participant` and `signal` must outlive it; `signal` is raised when a
  /// reader comes or goes.
  ReplyOutbox(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
              const ReplyLimits& limits = {})
      : participant_(participant),
        signal_(signal),
        limits_(limits),
        presence_(
            participant,
            gateway::dds::Partitions{gateway::dds::every_reply_partition(participant.options().partition)},
            &signal) {}
  /// Takes a second when a client has not acknowledged all of its replies.
  ~ReplyOutbox() {
    for (auto& [identity, client] : clients_) {
      if (!acknowledged(client)) ends_.end(std::move(client.writer));
    }
  }
  ReplyOutbox(const ReplyOutbox&) = delete;
  ReplyOutbox& operator=(const ReplyOutbox&) = delete;

  /// Writes `reply`, now or later, with a cause exactly when it says REPLY_REFUSED. `data` is what the reply
  /// borrows.
  void send(Reply reply, const Place& place, SteadyTime now, std::vector<std::uint8_t> data = {}) {
    (void)gateway::dds::settle_cause(reply);
    const Identity identity = identity_of(reply);
    const auto place_waits = per_place_.find(place);
    if ((place_waits != per_place_.end() && place_waits->second >= limits_.waiting_per_place) ||
        (!clients_.contains(identity) && clients_.size() >= limits_.clients && !make_place())) {
      ++dropped_;
      return;
    }
    Client& client = clients_[identity];
    client.gone = false;
    client.used = now;
    client.waiting_data += data.size();
    waiting_data_ += data.size();
    ++waiting_;
    ++per_place_[place];
    client.waiting.push_back({reply, place, now + kMatchTime, std::move(data)});
    make_room();
    // With others before it, it waits for the next call: not all are looked at for every one.
    if (client.waiting.size() == 1) serve(identity, client, now);
  }

  /// The client `key` names is gone: after the replies that still wait, nothing of it is kept here or, by
  /// DDS, in its readers.
  void forget(const Reply& key, SteadyTime now) {
    const auto known = clients_.find(identity_of(key));
    if (known == clients_.end()) return;
    known->second.gone = true;
    known->second.forget_at = now + kMatchTime;
  }

  /// Writes what waits and can be written, and gives up the writers of clients that are gone.
  void retry(SteadyTime now) {
    std::size_t ended = 0;
    for (auto next = clients_.begin(); next != clients_.end();) {
      const auto here = next++;
      Client& client = here->second;
      if (!client.waiting.empty() && now >= client.blocked_until) serve(here->first, client, now);
      // DDS takes a while for each; there may be hundreds when a network broke.
      constexpr std::size_t kEndsAtOnce = 8;
      if (!client.gone || ended == kEndsAtOnce || !client.waiting.empty()) continue;
      const bool has_all = acknowledged(client);
      if (!has_all && now < client.forget_at) continue;
      if (!has_all && !ends_.end(std::move(client.writer))) continue;
      erase(here);
      ++ended;
    }
  }

  /// When `retry` is to be called at the latest; nothing: nothing waits.
  std::optional<SteadyTime> next(SteadyTime now) const {
    const auto waits = [](const auto& entry) { return entry.second.gone || !entry.second.waiting.empty(); };
    if (std::none_of(clients_.begin(), clients_.end(), waits)) return std::nullopt;
    return now + kPause;
  }

  bool empty() const noexcept { return waiting_ == 0; }
  /// How many replies wait.
  std::size_t waiting() const noexcept { return waiting_; }
  /// Clients that have, or are to have, a writer.
  std::size_t clients() const noexcept { return clients_.size(); }
  /// Bytes that were written and, as of the last look, not all acknowledged.
  std::size_t under_way() const noexcept { return under_way_; }

  /// Waits at most `time` until the readers have all that was written.
  void wait_for_readers(dds_duration_t time) const noexcept {
    const dds_time_t end = dds_time() + time;
    for (const auto& [identity, client] : clients_) {
      const dds_duration_t left = std::max<dds_duration_t>(end - dds_time(), 0);
      if (client.writer) (void)dds_wait_for_acks(client.writer->handle(), left);
    }
  }

  /// Replies that were dropped since the last call.
  std::uint64_t take_dropped() noexcept { return std::exchange(dropped_, 0); }

 private:
  using Identity = std::array<std::uint8_t, 16>;
  using Writer = gateway::dds::Writer<Reply>;
  struct Item {
    Reply reply;
    Place place;
    SteadyTime give_up;
    std::vector<std::uint8_t> data;
    std::size_t bytes() const noexcept { return sizeof(Reply) + data.size(); }
  };
  struct Client {
    std::unique_ptr<Writer> writer;
    std::deque<Item> waiting;
    std::size_t waiting_data = 0;  ///< bytes
    std::size_t under_way = 0;     ///< bytes that were written, until all are acknowledged
    unsigned replies = 0;          ///< that these are
    dds_entity_t heard = 0;        ///< writer that its reader was matched with once; 0: none
    bool stood_still = false;      ///< it lost replies, and has acknowledged nothing since
    bool gone = false;
    SteadyTime used;       ///< the last reply came
    SteadyTime written;    ///< the last was written
    SteadyTime forget_at;  ///< of one that is gone: at the latest
    SteadyTime blocked_until;
    std::chrono::milliseconds pause = kPause;  ///< after the next write that times out
  };
  using Clients = std::map<Identity, Client>;

  static Identity identity_of(const Reply& reply) noexcept {
    Identity identity;
    std::copy(std::begin(reply.client), std::end(reply.client), identity.begin());
    return identity;
  }

  /// Writes what waits for one client, as far as it goes.
  void serve(const Identity& identity, Client& client, SteadyTime now) {
    if (!client.writer && !open(identity, client)) return;
    count_acknowledged(client);
    while (!client.waiting.empty()) {
      const Item& item = client.waiting.front();
      const dds_entity_t writer = client.writer->handle();  // another one after a change of the network
      if (client.heard != writer && has_reader(writer)) client.heard = writer;
      if (client.heard != writer) {
        if (now < item.give_up) return;
        if (!client.gone) ++dropped_;
        pop(client);
        continue;
      }
      const std::size_t most = client.stood_still ? 0 : limits_.under_way_each;
      if (client.under_way != 0 && client.under_way + item.bytes() > most) return;
      if (under_way_ + item.bytes() > limits_.under_way &&
          (!clear_way(item.bytes(), now) || !client.writer)) {
        return;
      }
      const dds_return_t written = client.writer->write(item.reply);
      if (written == DDS_RETCODE_TIMEOUT) {
        // What makes room comes with the next pass.
        client.blocked_until = std::chrono::steady_clock::now() + client.pause;
        client.pause = std::min(2 * client.pause, kLongestPause);
        return;
      }
      client.pause = kPause;
      client.written = now;
      if (written == DDS_RETCODE_OK) {
        client.under_way += item.bytes();
        under_way_ += item.bytes();
        ++client.replies;
      } else {
        ++dropped_;
      }
      pop(client);
    }
  }

  /// Makes the client's writer. False: there is none to be had, and its replies are dropped.
  bool open(const Identity& identity, Client& client) {
    try {
      client.writer = std::make_unique<Writer>(participant_,
                                               gateway::dds::Partitions{gateway::dds::reply_writer_partition(
                                                   participant_.options().partition, identity)},
                                               &signal_);
      return true;
    } catch (const gateway::dds::SetupError&) {
      for (; !client.waiting.empty(); pop(client)) ++dropped_;
      return false;
    }
  }

  static bool has_reader(dds_entity_t writer) {
    dds_publication_matched_status_t status = {};
    return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK && status.total_count > 0;
  }

  static bool acknowledged(const Client& client) {
    return !client.writer || dds_wait_for_acks(client.writer->handle(), 0) == DDS_RETCODE_OK;
  }

  void count_acknowledged(Client& client) {
    if (client.under_way == 0 || !acknowledged(client)) return;
    under_way_ -= std::exchange(client.under_way, 0);
    client.replies = 0;
    client.stood_still = false;
  }

  /// Makes room for so many bytes under way: those that have stood still for too long lose what they have not
  /// acknowledged. False: there is none yet.
  bool clear_way(std::size_t bytes, SteadyTime now) {
    const auto fits = [&] { return under_way_ == 0 || under_way_ + bytes <= limits_.under_way; };
    for (auto& [identity, client] : clients_) count_acknowledged(client);
    for (auto next = clients_.begin(); !fits() && next != clients_.end(); ++next) {
      Client& client = next->second;
      if (client.under_way == 0 || now < client.written + limits_.patience) continue;
      if (!ends_.end(std::move(client.writer))) break;
      dropped_ += std::exchange(client.replies, 0);
      under_way_ -= std::exchange(client.under_way, 0);
      client.heard = 0;
      client.stood_still = true;
    }
    return fits();
  }

  /// Makes place for one client more: the one that was idle longest gives its writer up. False: none is idle.
  bool make_place() {
    auto longest = clients_.end();
    for (auto each = clients_.begin(); each != clients_.end(); ++each) {
      const bool idle = each->second.waiting.empty() && acknowledged(each->second);
      if (idle && (longest == clients_.end() || each->second.used < longest->second.used)) longest = each;
    }
    if (longest == clients_.end()) return false;
    erase(longest);
    return true;
  }

  /// Drops the oldest of who has the most while too much waits.
  void make_room() {
    while (waiting_ > limits_.waiting || waiting_data_ > limits_.waiting_data) {
      const bool data = waiting_data_ > limits_.waiting_data;
      const auto most =
          std::max_element(clients_.begin(), clients_.end(), [data](const auto& one, const auto& other) {
            return data ? one.second.waiting_data < other.second.waiting_data
                        : one.second.waiting.size() < other.second.waiting.size();
          });
      ++dropped_;
      pop(most->second);
    }
  }

  void pop(Client& client) {
    const Item& item = client.waiting.front();
    const auto place_waits = per_place_.find(item.place);
    if (--place_waits->second == 0) per_place_.erase(place_waits);
    client.waiting_data -= item.data.size();
    waiting_data_ -= item.data.size();
    --waiting_;
    client.waiting.pop_front();
  }

  void erase(typename Clients::iterator client) {
    under_way_ -= client->second.under_way;
    clients_.erase(client);
  }

  const gateway::dds::Participant& participant_;
  gateway::dds::DataSignal& signal_;
  const ReplyLimits limits_;
  /// Writes nothing: matched with the readers of all clients, it tells them that a daemon answers.
  Writer presence_;
  Clients clients_;
  SlowEnds ends_;
  std::map<Place, unsigned> per_place_;  ///< how many of those that wait
  std::size_t waiting_ = 0;              ///< of all clients
  std::size_t waiting_data_ = 0;         ///< bytes
  std::size_t under_way_ = 0;            ///< bytes
  std::uint64_t dropped_ = 0;
};

}  // namespace cansyncd
