#include <cansync/job.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <mutex>
#include <utility>

#include "client/src/job_state.h"
#include "client/src/link.h"

namespace cansync::client {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kLook(20);           // how often a stop flag is looked at
constexpr milliseconds kCancelGrace(5000);  // a cancelled job's reply comes within this

/// In a callback of the job's own client.
template <class R>
bool in_own_callback(const detail::JobState<R>& state) {
  const auto link = state.link.lock();
  return link && link->is_receiver();
}

template <class R>
R not_in_a_callback() {
  return detail::of_nobody<R>(
      ReplyCode::no_reply,
      "a callback of this client waits for the reply, which comes only when it has returned; whether the request "
      "was done is not known; use then(), or another thread");
}

}  // namespace

template <class R>
R Job<R>::wait() const {
  std::unique_lock lock(state_->mutex);
  for (;;) {
    if (state_->reply) return *state_->reply;
    if (in_own_callback(*state_)) return not_in_a_callback<R>();
    if (state_->abandoned(std::chrono::steady_clock::now())) {
      lock.unlock();
      state_->end_abandoned();
      lock.lock();
      continue;
    }
    state_->changed.wait_until(lock, state_->last_moment());
  }
}

template <class R>
std::optional<R> Job<R>::wait_for(milliseconds time) const {
  const auto end = std::chrono::steady_clock::now() + time;
  const bool waits = !in_own_callback(*state_);
  std::unique_lock lock(state_->mutex);
  while (!state_->reply) {
    const auto now = std::chrono::steady_clock::now();
    if (state_->abandoned(now)) {
      lock.unlock();
      state_->end_abandoned();
      lock.lock();
    } else if (!waits || now >= end) {
      break;
    } else {
      state_->changed.wait_until(lock, std::min(end, state_->last_moment()));
    }
  }
  return state_->reply;
}

template <class R>
R Job<R>::wait(const std::atomic<bool>& stop, const OnProgress& on_progress) const {
  std::optional<std::chrono::steady_clock::time_point> give_up;
  std::uint64_t told = 0;
  std::unique_lock lock(state_->mutex);
  for (;;) {
    if (state_->progress != told) {
      told = state_->progress;
      const std::uint32_t done = state_->done;
      const std::uint32_t total = state_->total;
      lock.unlock();
      if (on_progress) on_progress(done, total);
      lock.lock();
    }
    if (state_->reply) return *state_->reply;
    if (in_own_callback(*state_)) return not_in_a_callback<R>();
    const auto now = std::chrono::steady_clock::now();
    if (state_->abandoned(now)) {
      lock.unlock();
      state_->end_abandoned();
      lock.lock();
      continue;
    }
    if (give_up && now >= *give_up) {
      R reply;
      reply.reason =
          "the daemon did not answer the cancel within 5 s; whether the request was done is not known";
      return reply;
    }
    if (!give_up && stop) {
      give_up = now + kCancelGrace;
      lock.unlock();
      (void)cancel();
      lock.lock();
    }
    state_->changed.wait_for(lock, kLook,
                             [&] { return state_->reply.has_value() || state_->progress != told; });
  }
}

template <class R>
Progress Job<R>::progress() const {
  const std::lock_guard lock(state_->mutex);
  return {state_->done, state_->total};
}

template <class R>
void Job<R>::then(std::function<void(const R&)> callback) const {
  {
    const std::lock_guard lock(state_->mutex);
    if (!state_->reply) {
      state_->callbacks.push_back(std::move(callback));
      return;
    }
  }
  callback(*state_->reply);  // never changes any more
}

template <class R>
std::future<R> Job<R>::future() const {
  auto promise = std::make_shared<std::promise<R>>();
  std::future<R> future = promise->get_future();
  then([promise = std::move(promise)](const R& reply) { promise->set_value(reply); });
  return future;
}

template <class R>
bool Job<R>::cancel() const {
  const std::shared_ptr<detail::Link> link = state_->link.lock();
  return link && link->cancel(state_->request);
}

template <class R>
std::uint64_t Job<R>::request() const noexcept {
  return state_->request;
}

template class Job<ParameterReply>;
template class Job<TransferReply>;
template class Job<CommandReply>;

}  // namespace cansync::client
