#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <concepts>
#include <cstdint>
#include <optional>

#include "can/bus.h"

namespace cansyncd {

/// A protocol without an interval, as `DeadlineLoop` drives it. Every function is called on the realtime
/// thread and must be realtime safe.
///
/// - `begin(now)`: once, before anything else.
/// - `advance(now)`: takes what other threads ask for, and does what is due at `now`. Afterwards
///   `next_deadline` lies after `now`.
/// - `receive(frame)`: a frame came, or the echo of an own one; in the order of the bus.
/// - `next_frame()`: what is to be handed to the bus now, if anything; followed by `handed_over(result)`. It
///   may be the same frame again when the bus did not take it.
/// - `waits_for_echo()`: the controller has no place for another frame before an own one is seen on the bus;
///   the loop then wakes for frames on every bus.
/// - `next_deadline()`: when `advance` must be called at the latest; Time::max() when no time is waited for.
/// - `publish(now)`: tells other threads what is new; before each sleep.
/// - `end(now)`: once, after all else: answers what is open.
template <class M>
concept DeadlineMachine = requires(M& machine, const M& constant, can::Time now,
                                   const can::ReceivedFrame& received, can::SendResult result) {
  { machine.begin(now) }
  noexcept;
  { machine.advance(now) }
  noexcept;
  { machine.receive(received) }
  noexcept;
  { machine.next_frame() }
  noexcept->std::same_as<std::optional<can::Frame>>;
  { machine.handed_over(result) }
  noexcept;
  { constant.waits_for_echo() }
  noexcept->std::same_as<bool>;
  { constant.next_deadline() }
  noexcept->std::same_as<can::Time>;
  { machine.publish(now) }
  noexcept;
  { machine.end(now) }
  noexcept;
};

/// The realtime thread's work for a protocol without an interval: binds a machine to a bus, sleeping until a
/// frame comes, the machine's next deadline, or the next look.
///
/// Looks stand on an absolute grid, `look` apart from the start on: what other threads ask for waits no
/// longer than that. One that has gone by is skipped, none is made up for.
///
/// All time comes from the bus, so the same loop runs in virtual time. Nothing allocates, locks, logs or
/// throws; the only system calls are the bus's and the machine's.
template <DeadlineMachine Machine>
class DeadlineLoop {
 public:
  /// Bus and machine must outlive the loop. `look` is over 0.
  DeadlineLoop(Machine& machine, can::Bus& bus, can::Time look = std::chrono::milliseconds(1)) noexcept
      : machine_(machine), bus_(bus), look_(look) {}

  /// Runs until `request_stop`. Call once, on the realtime thread.
  void run() noexcept {
    start();
    while (!stop_.load(std::memory_order_relaxed)) {
      serve();
      sleep(can::Time::max());
    }
    end();
  }

  // --- in the place of `run`, for a thread that has something else to do, too

  /// Once, before anything else.
  void begin() noexcept {
    start();
    serve();
  }
  /// Sleeps as `run` does, but not beyond `until`, and does what is due then.
  void turn(can::Time until) noexcept {
    sleep(until);
    serve();
  }
  /// Once, after all else.
  void end() noexcept { machine_.end(bus_.now()); }
  /// Everything that was due up to this instant is done.
  can::Time served() const noexcept { return served_; }

  /// Makes `run` return within one look. Any thread, also a signal handler.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }

  /// Wake-ups so far: stands still when the thread does. Any thread.
  std::uint64_t wake_ups() const noexcept { return wake_ups_.load(std::memory_order_relaxed); }

 private:
  /// Most frames handed over, and taken, at once: neither side starves the other.
  static constexpr unsigned kFramesSentAtOnce = 16;
  static constexpr unsigned kFramesTakenAtOnce = 64;

  void start() noexcept {
    const can::Time start = bus_.now();
    next_look_ = start + look_;
    machine_.begin(start);
  }

  void serve() noexcept {
    served_ = bus_.now();
    machine_.advance(served_);
    send();
    machine_.publish(bus_.now());
  }

  void sleep(can::Time until) noexcept {
    const can::Time deadline = std::min({machine_.next_deadline(), next_look_, until});
    (void)(machine_.waits_for_echo() ? bus_.wait_for_frame(deadline) : bus_.wait_until(deadline));
    wake_ups_.fetch_add(1, std::memory_order_relaxed);
    pass_looks(bus_.now());
    receive();
  }

  void send() noexcept {
    for (unsigned i = 0; i < kFramesSentAtOnce; ++i) {
      const std::optional<can::Frame> frame = machine_.next_frame();
      if (!frame) return;
      const can::SendResult result = bus_.send(*frame);
      machine_.handed_over(result);
      if (result != can::SendResult::queued) return;
    }
  }

  void receive() noexcept {
    can::ReceivedFrame received;
    for (unsigned i = 0; i < kFramesTakenAtOnce && bus_.receive(received); ++i) machine_.receive(received);
  }

  void pass_looks(can::Time now) noexcept {
    if (now < next_look_) return;
    next_look_ += look_ * ((now - next_look_) / look_ + 1);
  }

  Machine& machine_;
  can::Bus& bus_;
  const can::Time look_;
  can::Time next_look_{};
  can::Time served_{};
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> wake_ups_{0};
};

}  // namespace cansyncd
