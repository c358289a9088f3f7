#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "daemon/desk/event_text.h"
#include "daemon/desk/gateway_events.h"
#include "dds/signal.h"
#include "rt/wake_signal.h"

namespace cansyncd {

/// The thread of a protocol's gateway: one of normal priority that sleeps until the realtime thread or DDS
/// has something, or the next pass is due.
class GatewayThread {
 public:
  /// One pass over everything that may have come; returns when the next is due at the latest. The readers
  /// need to be asked only when `samples_may_wait`.
  using Pass = std::function<SteadyTime(bool samples_may_wait)>;

  /// `wake` is signalled by the realtime thread, `signal` raised by the readers; both must outlive this
  /// object, as must all that `pass` and `end` use. `end` runs last of all, on the same thread.
  GatewayThread(rt::WakeSignal& wake, gateway::dds::DataSignal& signal, Pass pass, std::function<void()> end);
  /// Stops.
  ~GatewayThread();
  GatewayThread(const GatewayThread&) = delete;
  GatewayThread& operator=(const GatewayThread&) = delete;

  /// Starts the thread; once. Throws std::system_error when there is no thread to be had.
  void start();

  /// Ends the thread after the pass it is in, and `end`. Further calls do nothing. Main thread.
  void stop() noexcept;

  /// True from `start` to `stop`. Main thread.
  bool runs() const noexcept { return thread_.joinable(); }

  /// Passes so far: stands still for longer than a second only when the thread does. Any thread.
  std::uint64_t passes() const noexcept { return passes_.load(std::memory_order_relaxed); }

 private:
  void run();

  rt::WakeSignal& wake_;
  gateway::dds::DataSignal& signal_;
  const Pass pass_;
  const std::function<void()> end_;
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> passes_{0};
  std::thread thread_;
};

/// Events of other threads on their way to the gateway thread. Any thread.
class PostedEvents {
 public:
  /// Most that wait; more are lost.
  static constexpr std::size_t kMost = 16;

  /// Takes an event; returns at once. The gateway thread must be woken afterwards.
  void post(const EventText& event);

  /// Publishes what was posted, in its order. Gateway thread.
  void publish(EventPublisher& events, SteadyTime now);

 private:
  std::mutex mutex_;
  std::vector<EventText> posted_;
};

}  // namespace cansyncd
