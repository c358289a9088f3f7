#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "dds/denial.h"
#include "dds/endpoint.h"
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

/// Which participants have a reader matched with one of our writers. Gateway thread only.
class MatchedPlaces {
 public:
  /// Looks again when a reader of `writer` came or went since the last call.
  void look(dds_entity_t writer);
  /// True when the participant has, or once had, a reader matched with the writer; also when `place` is not
  /// known. False: its reader may still come. As of the last `look`.
  bool has(const Place& place) const { return place == Place{} || !known_ || places_.contains(place); }

 private:
  std::set<Place> places_;  ///< matched now or before
  bool known_ = false;      ///< the writer could be asked
  std::uint32_t current_ = 0;
  std::uint32_t total_ = 0;
};

/// One reply topic. A reply that cannot be written now waits and is written later: while the client's reader
/// is not matched yet (DDS finds readers and writers of a client one by one, so a request may be here before
/// its client's reply reader is known), and while DDS waits for readers to acknowledge earlier ones. A write
/// hardly blocks: while this thread waits it takes no requests, and DDS handles no acknowledgement while a
/// reader of requests is full. Gateway thread only.
template <class Reply>
class ReplyOutbox {
 public:
  /// A reply waits so long for its client's reader.
  static constexpr std::chrono::seconds kMatchTime{2};
  /// Most replies that wait; then the oldest is dropped.
  static constexpr std::size_t kWaiting = 32768;
  /// Most of them for one participant, so that none takes the room of the others; more are dropped. Many more
  /// than DDS and the kernel keep of its requests ahead of its acknowledgements.
  static constexpr unsigned kWaitingPerPlace = 4096;
  /// Most bytes of data that wait; a reply with more is dropped.
  static constexpr std::size_t kWaitingData = 128u << 20;

  /// Throws gateway::dds::SetupError. `signal` is raised when a reader comes or goes.
  ReplyOutbox(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal)
      : writer_(participant, 0, &signal) {}

  /// Pause after a write that timed out, and between looks for readers.
  static constexpr std::chrono::milliseconds kPause{10};

  /// Writes `reply`, now or later, with a cause exactly when it says REPLY_REFUSED. `data` is what the reply
  /// borrows.
  void send(Reply reply, const Place& place, SteadyTime now, std::vector<std::uint8_t> data = {}) {
    (void)gateway::dds::settle_cause(reply);
    const auto place_waits = per_place_.find(place);
    if ((place_waits != per_place_.end() && place_waits->second >= kWaitingPerPlace) ||
        waiting_data_ + data.size() > kWaitingData) {
      ++dropped_;
      return;
    }
    make_room();
    ++per_place_[place];
    waiting_data_ += data.size();
    waiting_.push_back({reply, place, now + kMatchTime, std::move(data), false});
    // With others before it, it waits for the next call: not all are looked at for every one.
    if (waiting_.size() == 1) retry(now);
  }

  /// The client `key` names is gone: after the replies that still wait, nothing of it is kept here or, by
  /// DDS, in the readers.
  void forget(const Reply& key, SteadyTime now) {
    make_room();
    ++per_place_[Place{}];
    waiting_.push_back({key, Place{}, now, {}, true});
    if (waiting_.size() == 1) retry(now);
  }

  /// Writes what waits and can be written.
  void retry(SteadyTime now) {
    if (now < blocked_until_ || waiting_.empty()) return;
    matched_.look(writer_.handle());
    for (auto item = waiting_.begin(); item != waiting_.end();) {
      if (now < item->give_up && !matched_.has(item->place)) {
        ++item;
        continue;
      }
      const dds_return_t written =
          item->forget ? writer_.unregister(item->reply) : writer_.write(item->reply);
      if (written == DDS_RETCODE_TIMEOUT) {
        // What makes room comes with the next pass.
        blocked_until_ = std::chrono::steady_clock::now() + kPause;
        return;
      }
      if (written != DDS_RETCODE_OK && !item->forget) ++dropped_;
      item = erase(item);
    }
  }

  /// When `retry` is to be called at the latest; nothing: nothing waits.
  std::optional<SteadyTime> next(SteadyTime now) const {
    if (waiting_.empty()) return std::nullopt;
    return std::max(blocked_until_, now + kPause);
  }

  bool empty() const noexcept { return waiting_.empty(); }
  /// How many replies, and clients that are gone, wait: `kWaiting` at most.
  std::size_t waiting() const noexcept { return waiting_.size(); }

  /// Waits at most `time` until the readers have all that was written.
  void wait_for_readers(dds_duration_t time) const noexcept {
    (void)dds_wait_for_acks(writer_.handle(), time);
  }

  /// Replies that were dropped since the last call.
  std::uint64_t take_dropped() noexcept { return std::exchange(dropped_, 0); }

 private:
  struct Item {
    Reply reply;
    Place place;
    SteadyTime give_up;
    std::vector<std::uint8_t> data;
    bool forget;  ///< no reply: the client is gone
  };

  /// Before one more waits: drops the oldest when there are too many.
  void make_room() {
    while (waiting_.size() >= kWaiting) {
      // A key that is not given up costs its readers a little memory until they leave.
      if (!waiting_.front().forget) ++dropped_;
      erase(waiting_.begin());
    }
  }

  auto erase(typename std::deque<Item>::iterator item) {
    const auto place_waits = per_place_.find(item->place);
    if (--place_waits->second == 0) per_place_.erase(place_waits);
    waiting_data_ -= item->data.size();
    return waiting_.erase(item);
  }

  gateway::dds::Writer<Reply> writer_;
  MatchedPlaces matched_;
  std::deque<Item> waiting_;
  std::map<Place, unsigned> per_place_;  ///< how many of `waiting_`
  std::size_t waiting_data_ = 0;         ///< bytes
  std::uint64_t dropped_ = 0;
  SteadyTime blocked_until_;
};

}  // namespace cansyncd
