#pragma once

#include <cansync/client.h>
#include <cansync/topics.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "client/src/set_up.h"
#include "dds/ask/daemon_choice.h"
#include "dds/endpoint.h"

/// Internal to lib/client.
namespace cansync::client {

/// One subscription's callback. `running` is held during each call; a callback may end its own subscription.
struct Subscription::Hold {
  std::recursive_mutex running;
  std::shared_ptr<const std::function<void(const void*)>> callback;  // null: ended
  bool greeted = false;  // has got what was known when it came; receiver thread only

  void call(const void* sample) {
    const std::lock_guard lock(running);
    if (const auto function = callback) (*function)(sample);
  }
};

namespace detail {

/// What a feed keeps of its samples: the newest of each key, or of each kind the last `kKept`.
template <class T>
struct Kept {
  static constexpr std::size_t kKept = 1;
  static bool same_key(const T&, const T&) { return true; }
  static bool same_kind(const T&, const T&) { return true; }
};
template <>
struct Kept<ActualValues> {
  static constexpr std::size_t kKept = cansync_SLAVES;
  static bool same_key(const ActualValues& a, const ActualValues& b) { return a.slave == b.slave; }
  static bool same_kind(const ActualValues&, const ActualValues&) { return true; }
};
template <>
struct Kept<SlaveStatus> {
  static constexpr std::size_t kKept = cansync_SLAVES;
  static bool same_key(const SlaveStatus& a, const SlaveStatus& b) { return a.slave == b.slave; }
  static bool same_kind(const SlaveStatus&, const SlaveStatus&) { return true; }
};
template <>
struct Kept<Event> {
  static constexpr std::size_t kKept = 100;
  static bool same_key(const Event&, const Event&) { return false; }
  static bool same_kind(const Event& a, const Event& b) { return a.severity == b.severity; }
};

/// The participant of a daemon.
using Place = dds::DaemonChoice::Place;

/// One state topic: its reader from the first use on, what is known, and who wants to hear. Any thread may
/// call every function that does not say otherwise.
template <class T>
class Feed {
 public:
  /// Called with each sample and its writer before anybody else hears of it, by who takes it. Before `open`.
  void set_first_look(std::function<void(const T&, dds_instance_handle_t writer)> look) {
    first_look_ = std::move(look);
  }
  /// Asked every `kLook` while something is waited for, on the waiting thread; empty: nobody is. Before
  /// `open`.
  void set_go_on(std::function<bool()> go_on) { go_on_ = std::move(go_on); }
  /// Where the writer of a sample is, asked by who takes it. Before `open`.
  void set_place_of(std::function<Place(dds_entity_t reader, dds_instance_handle_t writer)> place_of) {
    place_of_ = std::move(place_of);
  }
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

  /// `look(known)`, with the lock held.
  template <class Look>
  void look(Look&& look) const {
    const std::lock_guard lock(mutex_);
    std::forward<Look>(look)(known_);
  }

  /// A copy of what is known.
  std::vector<T> known() const {
    const std::lock_guard lock(mutex_);
    return known_;
  }

  /// What a daemon that is there told last; waits for it up to `time`. Nothing when it has told nothing, or `go_on` says
  /// no.
  std::optional<T> wait_present(std::chrono::milliseconds time) {
    std::optional<T> newest;
    (void)wait_changed(time, [&] {
      if (!known_.empty() && is_of_the_living()) newest = known_.front();
      return newest.has_value();
    });
    return newest;
  }

  /// Waits until `condition(known)` holds, asked after each change; false when it does not within `time`, or
  /// `go_on` says no.
  template <class Condition>
  bool wait(std::chrono::milliseconds time, Condition&& condition) {
    return wait_changed(time, [&] { return condition(known_); });
  }

  /// The first that fits, of those that are known and of each that comes, as soon as it `counts`: both are asked without a
  /// lock, so that they may use the client. Nothing when none does within `time`, or `go_on` says no.
  template <class Counts>
  std::optional<T> wait_each(std::chrono::milliseconds time, Counts&& counts,
                             const std::function<bool(const T&)>& fits) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + time;
    const Watch watch(*this);
    std::optional<T> newest;  // that was not asked for yet
    while (true) {
      take();
      if (std::optional<T> one = watch.take(std::min(end, Clock::now() + kLook))) newest = std::move(one);
      if (newest && counts(*newest)) {
        if (fits(*newest)) return newest;
        newest.reset();
      }
      if (Clock::now() >= end || (go_on_ && !go_on_())) return std::nullopt;
    }
  }

  /// Waits until nothing has come for `quiet`, or for `most` at all.
  void wait_quiet(std::chrono::milliseconds quiet, std::chrono::milliseconds most) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + most;
    std::uint64_t seen = 0;
    const auto came = [&] { return std::exchange(seen, changes_) != changes_; };
    (void)wait_changed(std::chrono::milliseconds(0), came);
    auto left = most;
    while (left > std::chrono::milliseconds(0) && wait_changed(std::min(quiet, left), came))
      left = std::chrono::ceil<std::chrono::milliseconds>(end - Clock::now());
  }

  /// Takes what has come; subscribers hear of it with `tell`.
  void take() {
    const std::lock_guard lock(mutex_);
    if (reader_) take_samples();
  }

  /// Receiver thread: daemons are at these places, and nowhere else.
  void set_living(std::span<const Place> places) {
    const std::lock_guard lock(mutex_);
    if (knows_living_ && std::equal(living_.begin(), living_.end(), places.begin(), places.end())) return;
    living_.assign(places.begin(), places.end());
    knows_living_ = true;
    changed_.notify_all();
  }

  /// Receiver thread: what was told at other places than these is not known any more.
  void keep_of(std::span<const Place> places) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = known_.size(); i-- > 0;) {
      if (std::find(places.begin(), places.end(), places_[i]) != places.end()) continue;
      known_.erase(known_.begin() + static_cast<std::ptrdiff_t>(i));
      places_.erase(places_.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }

  /// Receiver thread: wakes who waits and calls the subscribers.
  void tell() {
    std::deque<T> news;
    std::deque<T> all;
    std::vector<std::shared_ptr<Subscription::Hold>> holds;
    bool is_present = false;  // what is known; what is not greets nobody
    {
      const std::lock_guard lock(mutex_);
      is_present = is_of_the_living();
      news = std::exchange(news_, {});
      std::erase_if(holds_,
                    [](const auto& hold) { return hold.use_count() == 1; });  // the subscription is gone
      holds = holds_;
      for (const auto& hold : holds) {
        if (!hold->greeted && is_present) all.assign(known_.begin(), known_.end());
      }
    }
    if (!news.empty()) changed_.notify_all();
    for (const auto& hold : holds) {
      for (const T& sample : hold->greeted ? news : all) hold->call(&sample);
      hold->greeted = hold->greeted || is_present;
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
  /// How often who waits asks `go_on_` and takes what has come: the receiver thread may stand in a callback, or be the
  /// one that waits.
  static constexpr std::chrono::milliseconds kLook{20};

  /// Waits until `condition()` holds, asked with the lock held after each change.
  template <class Condition>
  bool wait_changed(std::chrono::milliseconds time, Condition&& condition) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + time;
    while (true) {
      const auto next = std::min(end, Clock::now() + kLook);
      {
        std::unique_lock lock(mutex_);
        if (reader_) take_samples();
        if (changed_.wait_until(lock, next, condition)) return true;
      }
      if (next == end || (go_on_ && !go_on_())) return false;
    }
  }

  /// What comes while it lives, with what is known, for who looks at each.
  class Watch {
   public:
    explicit Watch(const Feed& feed) : feed_(feed) {
      const std::lock_guard lock(feed_.mutex_);
      come_.assign(feed_.known_.begin(), feed_.known_.end());
      feed_.watches_.push_back(&come_);
    }
    ~Watch() {
      const std::lock_guard lock(feed_.mutex_);
      std::erase(feed_.watches_, &come_);
    }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// The oldest; waits for it until `next`.
    std::optional<T> take(std::chrono::steady_clock::time_point next) const {
      std::unique_lock lock(feed_.mutex_);
      if (!feed_.changed_.wait_until(lock, next, [this] { return !come_.empty(); })) return std::nullopt;
      const T one = come_.front();
      come_.pop_front();
      return one;
    }

   private:
    const Feed& feed_;
    mutable std::deque<T> come_;
  };
  /// Of samples that who hears or looks at each has not got yet, the oldest goes.
  static constexpr std::size_t kWaiting = 1000;

  /// Daemons of a bus; more than one only while a dead one is not yet known to be dead.
  static constexpr std::size_t kWriters = 64;

  std::vector<dds_instance_handle_t> matched_now() const {
    std::vector<dds_instance_handle_t> found(reader_ ? kWriters : 0);
    if (!reader_) return found;
    const dds_return_t count = dds_get_matched_publications(reader_->handle(), found.data(), kWriters);
    found.resize(std::min(static_cast<std::size_t>(std::max(count, 0)), kWriters));
    return found;
  }

  /// Was what is known told by a daemon that is there? With the lock held.
  bool is_of_the_living() const {
    return !knows_living_ || places_.empty() ||
           std::find(living_.begin(), living_.end(), places_.front()) != living_.end();
  }

  void take_samples() {
    const auto on_sample = [&](const T& sample, const dds_sample_info_t& info) {
      if (!info.valid_data) return;
      if (writers_.size() >= kWriters) writers_.clear();
      writers_.insert(info.publication_handle);
      if (first_look_) first_look_(sample, info.publication_handle);
      keep(sample, place_of_ ? place_of_(reader_->handle(), info.publication_handle) : Place{0});
    };
    while (reader_->take_batch(on_sample) == dds::ReaderBase::kBatch) {
    }
  }

  void keep(const T& sample, Place place) {
    ++changes_;
    const auto add = [&sample](std::deque<T>& waiting) {
      if (waiting.size() == kWaiting) waiting.pop_front();
      waiting.push_back(sample);
    };
    add(news_);
    for (std::deque<T>* come : watches_) add(*come);
    for (std::size_t i = 0; i < known_.size(); ++i) {
      if (!Kept<T>::same_key(known_[i], sample)) continue;
      known_[i] = sample;
      places_[i] = place;
      return;
    }
    const auto is_alike = [&](const T& known) { return Kept<T>::same_kind(known, sample); };
    if (static_cast<std::size_t>(std::count_if(known_.begin(), known_.end(), is_alike)) == Kept<T>::kKept) {
      const auto oldest = std::find_if(known_.begin(), known_.end(), is_alike);
      places_.erase(places_.begin() + (oldest - known_.begin()));
      known_.erase(oldest);
    }
    known_.push_back(sample);
    places_.push_back(place);
  }

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::unique_ptr<dds::Reader<T>> reader_;
  std::function<void(const T&, dds_instance_handle_t)> first_look_;
  std::function<bool()> go_on_;
  std::function<Place(dds_entity_t, dds_instance_handle_t)> place_of_;
  std::vector<T> known_;
  std::vector<Place> places_;                // of each of them
  std::vector<Place> living_;                // where a daemon is
  bool knows_living_ = false;                // of topics without keys
  std::deque<T> news_;                       // that were not told yet
  std::set<dds_instance_handle_t> writers_;  // that have sent something
  std::uint64_t changes_ = 0;
  mutable std::vector<std::deque<T>*> watches_;
  std::vector<std::shared_ptr<Subscription::Hold>> holds_;
};

}  // namespace detail
}  // namespace cansync::client
