#pragma once

#include <dds/dds.h>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "dds/guard/topic_guard.h"
#include "dds/guard/writer_keys.h"
#include "dds/request_key.h"
#include "dds/signal.h"
#include "dds/topic.h"

namespace gateway::dds {

/// Keeps a reader of requests from getting full: DDS delivers on one thread, and a full reader holds up what
/// everybody else writes, of every topic. DDS keeps a key for as long as its writer lives, and a sample until
/// it is taken; those with one key too many are dropped before the reader keeps anything of them, and
/// counted; those of a client that has too many waiting are turned away, to be refused; those that are meant
/// for another daemon are dropped and counted, whatever else waits. Thread safe.
class KeyGuard final : public TopicGuard {
 public:
  /// Most keys of one writer, and of all writers together.
  static constexpr std::size_t kKeysPerWriter = 16;
  static constexpr std::size_t kKeys = 256;
  /// Most samples that wait for `taken`, of one key and together, and most bytes of data they carry.
  static constexpr std::size_t kSamplesPerKey = kOpenRequests;
  static constexpr std::size_t kSamples = kKeys * kSamplesPerKey;
  static constexpr std::size_t kBytesPerKey = 32u << 20;
  static constexpr std::size_t kBytes = 128u << 20;
  /// Most samples of one key, and together, that were turned away and wait to be refused; more are dropped.
  static constexpr std::size_t kTurnedAwayPerKey = 32768;
  static constexpr std::size_t kTurnedAway = 131072;

  /// What the guard has to know of a sample.
  struct Content {
    RequestKey key;
    std::size_t bytes = 0;   ///< of its data
    bool elsewhere = false;  ///< meant for another daemon
  };
  using Look = std::function<Content(const void* sample)>;

  /// A sample that found too many of its client before it.
  struct TurnedAway {
    RequestKey key;
    dds_instance_handle_t writer = 0;
  };

  /// `look` reads a sample of the topic. `signal` is raised when a sample was not let in; it must outlive the
  /// guard.
  KeyGuard(Look look, DataSignal& signal) : look_(std::move(look)), signal_(signal) {}

  /// A sample of this key, with so many bytes, was taken from the reader.
  void taken(dds_instance_handle_t key, std::size_t bytes) noexcept;

  /// Forgets the keys of writers that are not in `living`.
  void keep(std::span<const dds_instance_handle_t> living);

  /// Samples that were meant for another daemon, since the last call.
  std::uint64_t take_elsewhere() noexcept;

  /// Samples with a key too many since the last call.
  std::uint64_t take_dropped() noexcept;

  /// At most `most` of those that were turned away, the oldest first.
  std::vector<TurnedAway> take_turned_away(std::size_t most);
  /// Those that were turned away for which there was no room, since the last call.
  std::uint64_t take_forgotten() noexcept;

 private:
  struct Waiting {
    std::size_t samples = 0;
    std::size_t bytes = 0;
    std::size_t turned_away = 0;
  };

  bool accept(const void* sample, const dds_sample_info_t& info) noexcept override;
  void forget() noexcept override;
  bool let_in(const void* sample, const dds_sample_info_t& info);
  void forget_if_idle(dds_instance_handle_t key);

  struct Refused {
    TurnedAway what;
    dds_instance_handle_t key;
  };

  const Look look_;
  DataSignal& signal_;
  std::mutex mutex_;
  WriterKeys keys_{kKeysPerWriter, kKeys};
  std::map<dds_instance_handle_t, Waiting> waiting_;  ///< by key
  std::size_t samples_ = 0;                           ///< that wait
  std::size_t bytes_ = 0;
  std::deque<Refused> turned_away_;
  std::uint64_t elsewhere_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t forgotten_ = 0;
};

}  // namespace gateway::dds
