#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>

#include "export.h"
#include "types.h"

namespace cansync::client {

namespace detail {
class Link;
template <class R>
struct JobState;
}  // namespace detail

/// Bytes done and in total of a transfer.
using OnProgress = std::function<void(std::uint32_t done, std::uint32_t total)>;

/// How far a transfer is.
struct Progress {
  std::uint32_t done = 0;   ///< bytes
  std::uint32_t total = 0;  ///< bytes
};

/// One request on its way: wait for its terminal reply, or cancel it. Cheap to copy (copies name the same
/// request); every function may be called from any thread, and after the Client is gone (the reply is
/// `no_reply` then).
template <class R>
class CANSYNC_PUBLIC Job {
 public:
  /// Waits for the terminal reply. Always ends: with the daemon's reply; with `no_reply` when the daemon is
  /// gone; at the latest `Options::grace` after the monitoring time with `timeout` (it was cancelled) or
  /// `no_reply` (nothing is known of it). A reply that comes after that is ignored. In a callback of the job's client it
  /// ends at once, with `no_reply` when there is no reply yet; the job goes on.
  R wait() const;

  /// Waits at most `time`, in a callback of the job's client not at all; nothing when the request is still open.
  std::optional<R> wait_for(std::chrono::milliseconds time) const;

  /// Like `wait`, and calls `on_progress` (transfers; on this thread) on every change, and once a
  /// second before the first byte. When `stop` becomes
  /// true, for example from a signal handler, the job is cancelled on the bus and its terminal reply is
  /// awaited, at most 5 s (then `no_reply`). `stop` is looked at every 20 ms.
  R wait(const std::atomic<bool>& stop, const OnProgress& on_progress = {}) const;

  /// Bytes done and in total as the daemon has told last; zeros before it has, and for what is no transfer.
  Progress progress() const;

  /// Calls `callback` once with the terminal reply: on the client's receiver thread (as short as callbacks of
  /// subscriptions), or at once on this thread when the request has ended already. Must not throw. While another
  /// callback does not return it is not called.
  void then(std::function<void(const R&)> callback) const;

  /// The terminal reply as a future; never an exception. Like `then` it comes from the receiver thread.
  std::future<R> future() const;

  /// Asks the daemon to cancel; the reply says `cancelled` unless the job had ended before. Never blocks
  /// longer than 1 s; false when the daemon could not be told.
  bool cancel() const;

  /// Number of the request, as in the topics.
  std::uint64_t request() const noexcept;

 private:
  friend class Client;
  explicit Job(std::shared_ptr<detail::JobState<R>> state) : state_(std::move(state)) {}
  std::shared_ptr<detail::JobState<R>> state_;
};

using ParameterJob = Job<ParameterReply>;
using TransferJob = Job<TransferReply>;
using CommandJob = Job<CommandReply>;

}  // namespace cansync::client
