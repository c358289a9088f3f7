#include <cansync/reference_repeater.h>
#include <cansync/topics.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "client/src/link.h"
#include "client/src/reference_turn.h"
#include "text/counts.h"

namespace cansync::client {
namespace {

constexpr std::chrono::microseconds kShortest(100);

std::uint32_t needed(std::chrono::microseconds period, std::uint64_t interval_ns) {
  return release_intervals_for(period, std::chrono::nanoseconds(std::max<std::uint64_t>(interval_ns, 1)));
}

}  // namespace

struct ReferenceRepeater::Impl {
  Impl(Client& client, std::chrono::microseconds every, std::int32_t strength, std::uint32_t intervals)
      : link(client.link_),
        writer(client, strength),
        period(std::max(every, kShortest)),
        wanted_release(intervals),
        interval_length(client.master_status().interval_length),
        followed(client.on_master_status(
            [this](const MasterStatus& status) { interval_length = status.interval_length; })) {
    if (const auto most = needed(period, interval_length);
        wanted_release == 0 && most > kMostReleaseIntervals) {
      throw SetupError(fmt::format(
          "reference values every {} us have to be released for {}, so that two late ones leave no "
          "gap; allowed: {}: give them more often, or name release_intervals",
          period.count(), text::counted(most, "interval"), kMostReleaseIntervals));
    }
  }

  std::uint32_t release_intervals() const {
    return wanted_release != 0 ? wanted_release
                               : std::min(needed(period, interval_length), kMostReleaseIntervals);
  }

  void run() {
    auto next = std::chrono::steady_clock::now();
    std::unique_lock lock(mutex);
    while (!stopped) {
      if (const auto meant_for = std::exchange(wanted_again, {})) writer.take_up(*meant_for);
      const std::array<RepeatedTelegram, 2> now = telegrams;
      lock.unlock();
      std::string failed = write_turn(now, [&](std::uint8_t telegram, const RepeatedTelegram& values) {
        return writer.write(telegram, values.value, values.valid, release_intervals());
      });
      const ReferenceStanding seen = writer.standing();
      lock.lock();
      if (!wanted_again) {
        if (standing == ReferenceStanding::current) error = std::move(failed);
        if (seen != ReferenceStanding::current) lose(seen);
      }
      // What was missed is not made up for.
      next = std::max(next + period, std::chrono::steady_clock::now());
      changed.wait_until(lock, next, [&] { return stopped; });
    }
  }

  /// Nothing that was set before goes out again.
  void lose(ReferenceStanding now) {
    if (standing == ReferenceStanding::current) {
      writer.release(1);
      writer.release(2);
      error = now == ReferenceStanding::daemon_restarted
                  ? "the daemon was started anew, and settings that clients had made are lost"
                  : "the mapping of the reference values was changed";
      error += ": nothing is repeated until the program calls take_up()";
    }
    standing = now;
    telegrams = {};
  }

  const std::shared_ptr<detail::Link> link;
  ReferenceWriter writer;
  const std::chrono::microseconds period;
  const std::uint32_t wanted_release;          ///< 0: what the period needs
  std::atomic<std::uint64_t> interval_length;  ///< ns; a daemon that was started anew may have another
  const Subscription followed;
  std::mutex mutex;
  std::condition_variable changed;
  std::array<RepeatedTelegram, 2> telegrams;
  bool stopped = false;
  std::optional<Validity> wanted_again;  ///< what take_up was called for, until the thread has seen it
  ReferenceStanding standing = ReferenceStanding::current;
  std::string error;
  std::thread thread;
};

ReferenceRepeater::ReferenceRepeater(Client& client, std::chrono::microseconds period, std::int32_t strength,
                                     std::uint32_t release_intervals)
    : impl_(std::make_unique<Impl>(client, period, strength, release_intervals)) {
  impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

ReferenceRepeater::~ReferenceRepeater() {
  stop();
}

void ReferenceRepeater::set(std::uint8_t telegram, const std::array<std::int32_t, 4>& value,
                            std::uint8_t valid) {
  if (telegram < 1 || telegram > 2) return;
  const std::lock_guard lock(impl_->mutex);
  impl_->telegrams[telegram - 1u] = {value, valid};
}

void ReferenceRepeater::stop() {
  std::thread thread;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stopped = true;
    thread.swap(impl_->thread);
  }
  impl_->changed.notify_all();
  if (!thread.joinable()) return;
  thread.join();
  impl_->writer.release(1);
  impl_->writer.release(2);
}

ReferenceStanding ReferenceRepeater::standing() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->standing;
}

void ReferenceRepeater::take_up() {
  take_up(impl_->link->validity());
}

void ReferenceRepeater::take_up(const Validity& meant_for) {
  const std::lock_guard lock(impl_->mutex);
  impl_->telegrams = {};
  impl_->wanted_again = meant_for;
  impl_->standing = ReferenceStanding::current;
}

std::string ReferenceRepeater::error() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->error;
}

}  // namespace cansync::client
