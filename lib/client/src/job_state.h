#pragma once

#include <cansync/job.h>
#include <cansync/types.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dds/ask/daemon_choice.h"
#include "text/counts.h"

/// Internal to lib/client.
namespace cansync::client::detail {

/// The reply of a request that nobody has answered.
template <class R>
R of_nobody(ReplyCode code, const std::string& reason) {
  R reply;
  reply.code = code;
  reply.reason = reason;
  reply.speaker = Speaker::nobody;
  return reply;
}

/// One request of a client, shared by its Job and the receiver thread.
template <class R>
struct JobState {
  std::mutex mutex;
  std::condition_variable changed;
  std::optional<R> reply;  // once there, it never changes
  std::vector<std::function<void(const R&)>> callbacks;
  std::uint32_t done = 0;
  std::uint32_t total = 0;
  std::uint64_t progress = 0;  // rises with each progress sample
  std::uint64_t request = 0;   // constant from here on
  std::weak_ptr<Link> link;
  gateway::dds::DaemonIdentity daemon = {};  // whom it is for; all zero: it was not sent

  // Of a request whose reply does not come. The first two stay as they are, the others are guarded by
  // `mutex`.
  using Clock = std::chrono::steady_clock;
  std::chrono::milliseconds monitoring{0};
  std::chrono::milliseconds grace{0};
  Clock::time_point since;  // submitted; transfers: last sign that the daemon has it
  bool given_up = false;    // the library has asked for its cancellation

  /// When the library cancels it.
  Clock::time_point cancel_at() const { return since + monitoring + grace / 2; }
  /// When it ends without a reply.
  Clock::time_point end_at() const { return since + monitoring + grace; }
  /// The receiver thread ends it by then; when that one stands in a callback, who waits for the job does.
  Clock::time_point last_moment() const { return end_at() + std::chrono::seconds(1); }
  bool abandoned(Clock::time_point now) const { return !reply && now >= last_moment(); }

  bool ended() {
    const std::lock_guard lock(mutex);
    return reply.has_value();
  }

  /// Ends it as one of which nothing is known.
  void end_unheard() {
    end(ReplyCode::no_reply,
        fmt::format("the daemon gave no reply within {} (monitoring time {} and {} of grace); whether the "
                    "request was done is not known",
                    text::duration_text(monitoring + grace), text::duration_text(monitoring),
                    text::duration_text(grace)));
  }

  /// By who waits while the receiver thread, which then calls the callbacks, stands in one.
  void end_abandoned() {
    settle(of_nobody<R>(
        ReplyCode::no_reply,
        "no reply was taken in its time, for a callback of this client has not returned; whether "
        "the request was done is not known"));
  }

  /// Ends the job, unless it has ended, and calls the callbacks.
  void finish(R&& terminal) {
    settle(std::move(terminal));
    std::vector<std::function<void(const R&)>> waiting;
    {
      const std::lock_guard lock(mutex);
      waiting.swap(callbacks);
    }
    for (const auto& callback : waiting) callback(*reply);
  }
  /// Ends the job; a second reply is ignored.
  void settle(R&& terminal) {
    {
      const std::lock_guard lock(mutex);
      if (reply) return;
      if (given_up && terminal.code == ReplyCode::cancelled) {
        terminal.code = ReplyCode::timeout;
        terminal.speaker = Speaker::client;
        terminal.reason = fmt::format(
            "no reply within {} (monitoring time {}): the line has too much to do; the request was "
            "cancelled",
            text::duration_text(monitoring + grace / 2), text::duration_text(monitoring));
      }
      reply = std::move(terminal);
    }
    changed.notify_all();
  }
  /// Nobody has answered, or nobody was there: no_reply or no_daemon.
  void end(ReplyCode code, const std::string& reason) { finish(of_nobody<R>(code, reason)); }
  /// The library itself does not send it.
  void refuse(RefusalCause cause, const std::string& reason) {
    R terminal;
    terminal.code = ReplyCode::refused;
    terminal.cause = cause;
    terminal.reason = reason;
    terminal.speaker = Speaker::client;
    finish(std::move(terminal));
  }
};

/// The open jobs of one kind, by request number. Guarded by the link's mutex.
template <class R>
class OpenJobs {
 public:
  using State = std::shared_ptr<JobState<R>>;

  void add(const State& state) { open_.emplace(state->request, state); }

  /// The job of a request; nullptr when it is not (or no longer) open.
  State find(std::uint64_t request) const {
    const auto entry = open_.find(request);
    return entry == open_.end() ? nullptr : entry->second;
  }

  State remove(std::uint64_t request) {
    State state = find(request);
    open_.erase(request);
    return state;
  }

  std::size_t size() const { return open_.size(); }

  /// Jobs whose reply is late: those to be cancelled now (told once), and those that are over, which it
  /// removes.
  void look_at_time(std::chrono::steady_clock::time_point now, std::vector<std::uint64_t>& cancel,
                    std::vector<State>& over) {
    for (auto entry = open_.begin(); entry != open_.end();) {
      JobState<R>& job = *entry->second;
      std::unique_lock lock(job.mutex);
      // Never both at once: the answer to the cancel has to have time to come.
      const bool ended = job.given_up && (job.reply.has_value() || now >= job.end_at());
      if (!job.given_up && now >= job.cancel_at()) {
        job.given_up = true;
        cancel.push_back(job.request);
      }
      lock.unlock();
      if (!ended) {
        ++entry;
        continue;
      }
      over.push_back(entry->second);
      entry = open_.erase(entry);
    }
  }

  /// Removes and returns the jobs whose daemon can answer them no more.
  template <class MayAnswer>
  std::vector<State> remove_lost(MayAnswer&& may_answer) {
    std::vector<State> lost;
    for (auto entry = open_.begin(); entry != open_.end();) {
      if (may_answer(entry->second->daemon)) {
        ++entry;
        continue;
      }
      lost.push_back(entry->second);
      entry = open_.erase(entry);
    }
    return lost;
  }

 private:
  std::map<std::uint64_t, State> open_;
};

}  // namespace cansync::client::detail
