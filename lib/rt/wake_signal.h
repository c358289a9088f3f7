#pragma once

#include <atomic>
#include <chrono>

#include "system/descriptor.h"

namespace rt {

/// Wakes one thread from any other: an eventfd. `signal` is realtime safe: one system call when none is
/// pending, none otherwise. Whoever takes a signal must look at the data after taking it, not before.
class WakeSignal {
 public:
  /// Throws std::system_error when the process has no file descriptor left.
  WakeSignal();

  /// Makes the next (or running) `wait` return; signals that nobody waited for count as one. Never blocks.
  void signal() noexcept;

  /// Waits for a signal and takes it; false when `timeout` passed without one. 0 only looks.
  bool wait(std::chrono::milliseconds timeout) noexcept;

  /// Takes a pending signal without waiting; for callers that poll `descriptor` themselves.
  void clear() noexcept;

  /// File descriptor, readable while a signal is pending; for poll(), epoll or a DDS guard condition.
  int descriptor() const noexcept { return descriptor_.number(); }

 private:
  sys::Descriptor descriptor_;
  std::atomic<bool> pending_{false};
};

}  // namespace rt
