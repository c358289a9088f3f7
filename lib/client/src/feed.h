#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include "client/src/set_up.h"
#include "dds/endpoint.h"

/// Internal to lib/client.
namespace cansync::client {

/// One subscription's callback. `running` is held during each call.
struct Subscription::Hold {
  std::mutex running;
  std::function<void(const void*)> callback;  // empty: ended
  bool greeted = false;                       // has got what was known when it came; receiver thread only

  void call(const void* sample) {
    const std::lock_guard lock(running);
    if (callback) callback(sample);
  }
};

namespace detail {

/// What a feed keeps of its samples: the newest of each key, or the last `kKept`.
template <class T>
struct Kept {
  static constexpr std::size_t kKept = 1;
  static bool same_key(const T&, const T&) { return true; }
};
template <>
struct Kept<ActualValues> {
  static constexpr std::size_t kKept = cansync_SLAVES;
  static bool same_key(const ActualValues& a, const ActualValues& b) { return a.slave == b.slave; }
};
template <>
struct Kept<SlaveStatus> {
  static constexpr std::size_t kKept = cansync_SLAVES;
  static bool same_key(const SlaveStatus& a, const SlaveStatus& b) { return a.slave == b.slave; }
};
template <>
struct Kept<Event> {
  static constexpr std::size_t kKept = 300;  // the last 100 of each level
  static bool same_key(const Event&, const Event&) { return false; }
};

/// One state topic: its reader from the first use on, what is known, and who wants to hear. Any thread may
/// call every function but `dispatch`.
template <class T>
class Feed {
 public:
  /// Called with each sample and its writer before anybody else hears of it, on the receiver thread. Before
  /// `open`.
  void set_first_look(std::function<void(const T&, dds_instance_handle_t writer)> look) {
    first_look_ = std::move(look);
  }
  /// Asked every `kAsk` while something is waited for, on the waiting thread; empty: nobody is. Before
  /// `open`.
  void set_go_on(std::function<bool()> go_on) { go_on_ = std::move(go_on); }
  /// The reader; after `open`.
  dds_entity_t reader() const noexcept { return reader_->handle(); }

  /// Creates the reader unless there is one. Throws SetupError.
  void open(const dds::Participant& participant, dds::DataSignal& signal) {
    const std::lock_guard lock(mutex_);
    if (reader_) return;
    reader_ = set_up([&] { return std::make_unique<dds::Reader<T>>(participant, &signal); });
  }

  void add(std::shared_ptr<Subscription::Hold> hold) {
    const std::lock_guard lock(mutex_);
    holds_.push_back(std::move(hold));
  }

  /// A copy of what is known.
  std::vector<T> known() const {
    const std::lock_guard lock(mutex_);
    return known_;
  }

  /// Waits until `condition(known)` holds, asked after each change; false when it does not within `time`, or
  /// `go_on` says no.
  template <class Condition>
  bool wait(std::chrono::milliseconds time, Condition&& condition) const {
    return wait_changed(time, [&] { return condition(known_); });
  }

  /// Waits until nothing has come for `quiet`.
  void wait_quiet(std::chrono::milliseconds quiet) const {
    std::uint64_t seen = 0;
    const auto came = [&] { return std::exchange(seen, changes_) != changes_; };
    (void)wait_changed(std::chrono::milliseconds(0), came);
    while (wait_changed(quiet, came)) continue;
  }

  /// Receiver thread: takes what has come and calls the subscribers.
  void dispatch() {
    std::vector<T> news;
    std::vector<T> all;
    std::vector<std::shared_ptr<Subscription::Hold>> holds;
    {
      const std::lock_guard lock(mutex_);
      if (!reader_) return;
      take(news);
      std::erase_if(holds_,
                    [](const auto& hold) { return hold.use_count() == 1; });  // the subscription is gone
      holds = holds_;
      for (const auto& hold : holds) {
        if (!hold->greeted) all = known_;
      }
    }
    if (!news.empty()) changed_.notify_all();
    for (const auto& hold : holds) {
      for (const T& sample : hold->greeted ? news : all) hold->call(&sample);
      hold->greeted = true;
    }
  }

  /// The writers that are matched now.
  std::vector<dds_instance_handle_t> matched() const {
    const std::lock_guard lock(mutex_);
    return matched_now();
  }

  /// How many of the writers matched now have sent something here.
  std::size_t heard() const {
    const std::lock_guard lock(mutex_);
    const std::vector<dds_instance_handle_t> all = matched_now();
    return static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](auto writer) { return writers_.contains(writer); }));
  }

 private:
  /// How often `go_on_` is asked.
  static constexpr std::chrono::milliseconds kAsk{20};

  /// Waits until `condition()` holds, asked with the lock held after each change.
  template <class Condition>
  bool wait_changed(std::chrono::milliseconds time, Condition&& condition) const {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + time;
    while (true) {
      const auto next = go_on_ ? std::min(end, Clock::now() + kAsk) : end;
      {
        std::unique_lock lock(mutex_);
        if (changed_.wait_until(lock, next, condition)) return true;
      }
      if (next == end || !go_on_()) return false;
    }
  }

  /// Daemons of a bus; more than one only while a dead one is not yet known to be dead.
  static constexpr std::size_t kWriters = 64;

  std::vector<dds_instance_handle_t> matched_now() const {
    std::vector<dds_instance_handle_t> found(reader_ ? kWriters : 0);
    if (!reader_) return found;
    const dds_return_t count = dds_get_matched_publications(reader_->handle(), found.data(), kWriters);
    found.resize(std::min(static_cast<std::size_t>(std::max(count, 0)), kWriters));
    return found;
  }

  void take(std::vector<T>& news) {
    const auto on_sample = [&](const T& sample, const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      if (writers_.size() >= kWriters) writers_.clear();
      writers_.insert(info.publication_handle);
      if (first_look_) first_look_(sample, info.publication_handle);
      keep(sample, news);
    };
    while (reader_->take_batch(on_sample) == dds::ReaderBase::kBatch) {
    }
  }

  void keep(const T& sample, std::vector<T>& news) {
    news.push_back(sample);
    ++changes_;
    for (T& known : known_) {
      if (Kept<T>::same_key(known, sample)) {
        known = sample;
        return;
      }
    }
    if (known_.size() == Kept<T>::kKept) known_.erase(known_.begin());
    known_.push_back(sample);
  }

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::unique_ptr<dds::Reader<T>> reader_;
  std::function<void(const T&, dds_instance_handle_t)> first_look_;
  std::function<bool()> go_on_;
  std::vector<T> known_;
  std::set<dds_instance_handle_t> writers_;  // that have sent something
  std::uint64_t changes_ = 0;
  std::vector<std::shared_ptr<Subscription::Hold>> holds_;
};

}  // namespace detail
}  // namespace cansync::client
