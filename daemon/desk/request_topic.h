#pragma once

#include <dds/dds.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/desk/access.h"
#include "daemon/desk/client_table.h"
#include "daemon/desk/gateway_replies.h"
#include "daemon/desk/request_readers.h"
#include "dds/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/guard/key_guard.h"
#include "dds/reply_partition.h"
#include "dds/request_key.h"
#include "dds/signal.h"

namespace cansyncd {

/// What topics of requests are made with.
struct TopicSetup {
  const gateway::dds::Participant& participant;
  gateway::dds::DataSignal& signal;          ///< raised when something came; must outlive the topics
  RequestReaders& readers;                   ///< gets every reader; must outlive the topics
  gateway::dds::DaemonIdentity daemon = {};  ///< this start: what is meant for another is not read
  bool secured = false;                      ///< DDS Security is on
};

/// A topic of requests that tells its clients how far a request has come: `Row::Progress` is the type of that
/// topic.
template <class Row>
concept ShowsProgress = requires {
  typename Row::Progress;
};

/// Tells clients how far their requests have come, each in its own partition; nothing for topics that do not
/// tell. Gateway thread only.
template <class Row>
struct ProgressTopic {
  explicit ProgressTopic(const gateway::dds::Participant& /*participant*/) {}
};
template <ShowsProgress Row>
class ProgressTopic<Row> {
 public:
  explicit ProgressTopic(const gateway::dds::Participant& participant)
      : participant_(participant),
        presence_(
            participant,
            gateway::dds::Partitions{gateway::dds::every_reply_partition(participant.options().partition)},
            nullptr) {}

  /// `key`: of a client that is known and forgotten later. Nothing is told while DDS has no writer left.
  void tell(const gateway::dds::RequestKey& key, std::uint32_t done, std::uint32_t total) {
    auto& writer = writers_[key.client];
    try {
      if (!writer) {
        const auto own = gateway::dds::reply_partition(participant_.options().partition, key.client);
        writer = std::make_unique<Writer>(participant_, gateway::dds::Partitions{own}, nullptr);
      }
      (void)writer->write(Row::progress(key, done, total));
    } catch (const gateway::dds::SetupError&) {
    }
  }
  void forget(const ClientIdentity& identity) { writers_.erase(identity); }

 private:
  using Writer = gateway::dds::Writer<typename Row::Progress>;
  const gateway::dds::Participant& participant_;
  /// Writes nothing: matched with the readers of all clients.
  Writer presence_;
  std::map<ClientIdentity, std::unique_ptr<Writer>> writers_;  ///< of clients that have had requests open
};

/// Reads one topic whose samples are requests or cancels; no client can fill it. Gateway thread only.
template <class Sample>
class GuardedReader {
 public:
  /// `right`: what the topic gives who may write it. Throws gateway::dds::SetupError.
  GuardedReader(const TopicSetup& setup, const gateway::dds::TopicInfo& topic, Right right)
      : guard_([own = setup.daemon](const void* sample) { return content_of(sample, own); }, setup.signal),
        reader_(setup.participant, topic, &setup.signal, &guard_),
        right_(right) {
    setup.readers.add(reader_, guard_);
  }

  /// Takes a batch: `take(sample, place, written)`, the time in ns of the client's clock. True: there may be
  /// more.
  template <class Take>
  bool take(PlaceFinder& places, Take&& take) {
    const auto count = reader_.take_batch([&](const Sample& sample, const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      guard_.taken(info.instance_handle, bytes_of(sample));
      take(sample, places.find(reader_.handle(), info.publication_handle), info.source_timestamp);
    });
    return count == gateway::dds::ReaderBase::kBatch;
  }

  /// Takes a few of those for which their client had too many waiting: `take(key, place)`. True: there may be
  /// more.
  template <class Take>
  bool take_turned_away(PlaceFinder& places, Take&& take) {
    const auto refused = guard_.take_turned_away(RequestReaders::kRefusedAtOnce);
    for (const auto& sample : refused) take(sample.key, places.find(reader_.handle(), sample.writer));
    return refused.size() == RequestReaders::kRefusedAtOnce;
  }

  Right right() const noexcept { return right_; }

 private:
  static gateway::dds::KeyGuard::Content content_of(const void* sample,
                                                    const gateway::dds::DaemonIdentity& own) {
    using gateway::dds::Addressee;
    const auto& request = *static_cast<const Sample*>(sample);
    const Addressee whom = gateway::dds::addressee(gateway::dds::daemon_of(request), own);
    return {gateway::dds::key_of(request), bytes_of(request), whom == Addressee::another_daemon};
  }
  static std::size_t bytes_of(const Sample& request) {
    std::size_t bytes = 0;
    if constexpr (requires { request.data._length; }) bytes += request.data._length;
    if constexpr (requires { request.long_data._length; }) bytes += request.long_data._length;
    return bytes;
  }

  gateway::dds::KeyGuard guard_;
  gateway::dds::Reader<Sample> reader_;
  Right right_;
};

/// One topic of requests, with the topic of its replies. `Row` says what they are (see job_desk.h). Gateway
/// thread only.
template <class Row>
class RequestTopic {
 public:
  using RowType = Row;
  using Sample = typename Row::Sample;
  using Reply = typename Row::Reply;
  /// With DDS Security on, a second topic of the same type is read that gives every right.
  static constexpr bool kHasEngineerTopic = requires { Row::kEngineerTopic; };
  /// A pass takes this many of them, the rest of a batch waits: a pass over 128 would keep others waiting.
  static constexpr bool kFewAtOnce = requires { Row::kAtOnce; };

  /// Throws gateway::dds::SetupError.
  explicit RequestTopic(const TopicSetup& setup)
      : reader_(setup, gateway::dds::topic_info<Sample>, setup.secured ? Row::kRight : Right::engineer),
        replies_(setup.participant, setup.signal),
        progress_(setup.participant) {
    // Permissions of DDS Security are by topic; without it everybody may do everything.
    if constexpr (kHasEngineerTopic) {
      if (setup.secured) engineers_.emplace(setup, Row::kEngineerTopic, Right::engineer);
    }
  }

  /// Takes requests, `all` or a few: `take(sample, place, right, written)`. True: there may be more.
  template <class Take>
  bool take(PlaceFinder& places, bool all, Take&& take) {
    if constexpr (kFewAtOnce) {
      return take_few(places, all, take);
    } else {
      bool more = reader_.take(places, with_right(reader_, take));
      if (engineers_) more = engineers_->take(places, with_right(*engineers_, take)) || more;
      return more;
    }
  }

  /// Takes a few that are to be refused unread: `take(key, place)`. True: there may be more.
  template <class Take>
  bool take_turned_away(PlaceFinder& places, Take&& take) {
    const bool more = reader_.take_turned_away(places, take);
    return (engineers_ && engineers_->take_turned_away(places, take)) || more;
  }

  /// Tells how far a request has come, if the topic does.
  void tell_progress(const gateway::dds::RequestKey& key, std::uint32_t done, std::size_t total) {
    if constexpr (ShowsProgress<Row>) {
      progress_.tell(key, done, static_cast<std::uint32_t>(total));
    }
  }

  /// After the replies that still wait nothing is kept of the client.
  void forget(const ClientIdentity& identity, SteadyTime now) {
    Reply key = {};
    std::copy(identity.begin(), identity.end(), std::begin(key.client));
    replies_.forget(key, now);
    if constexpr (ShowsProgress<Row>) {
      progress_.forget(identity);
    }
  }

  ReplyOutbox<Reply>& replies() noexcept { return replies_; }
  const ReplyOutbox<Reply>& replies() const noexcept { return replies_; }

 private:
  struct Taken {
    Sample sample;
    Place place;
    std::int64_t written = 0;
  };

  template <class Take>
  static auto with_right(const GuardedReader<Sample>& reader, Take& take) {
    return [&take, right = reader.right()](const Sample& sample, const Place& place, std::int64_t written) {
      take(sample, place, right, written);
    };
  }

  template <class Take>
  bool take_few(PlaceFinder& places, bool all, Take& take) {
    static_assert(!kHasEngineerTopic, "requests that wait here have one right");
    static_assert(
        !requires(Sample sample) { sample.data._buffer; }, "what a sample points to is lent");
    if (taken_.empty()) {
      (void)reader_.take(places, [&](const Sample& sample, const Place& place, std::int64_t written) {
        taken_.push_back({sample, place, written});
      });
    }
    const std::size_t most = all ? taken_.size() : std::size_t{Row::kAtOnce};
    for (std::size_t i = 0; i < most && !taken_.empty(); ++i) {
      const Taken& next = taken_.front();
      take(next.sample, next.place, reader_.right(), next.written);
      taken_.pop_front();
      if (taken_.empty()) return true;  // there may be more in the reader
    }
    return !taken_.empty();
  }

  GuardedReader<Sample> reader_;
  std::optional<GuardedReader<Sample>> engineers_;
  ReplyOutbox<Reply> replies_;
  ProgressTopic<Row> progress_;
  std::deque<Taken> taken_;  ///< from the reader, not looked at yet; at most a batch
};

}  // namespace cansyncd
