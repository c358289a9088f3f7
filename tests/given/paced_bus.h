#pragma once

#include <condition_variable>
#include <mutex>

#include "disturbed_bus.h"

namespace given {

/// A bus whose time goes on as far as the test lets it; the loop on it has a thread of its own.
class PacedBus final : public DisturbedBus {
 public:
  using DisturbedBus::DisturbedBus;

  can::Wake wait_until(can::Time deadline) noexcept override {
    std::unique_lock lock(mutex_);
    while (deadline > limit_) {
      if (behind_.now() < limit_) {
        const can::Wake wake = behind_.wait_until(limit_);
        if (wake == can::Wake::frame) return wake;
      }
      parked_ = true;
      changed_.notify_all();
      changed_.wait(lock, [&] { return !parked_; });
    }
    return behind_.wait_until(deadline);
  }
  /// Time goes on to `limit`; returns when it stands there.
  void go_on(can::Time limit) {
    std::unique_lock lock(mutex_);
    limit_ = limit;
    parked_ = false;
    changed_.notify_all();
    changed_.wait(lock, [&] { return parked_; });
  }
  /// Time stands no more.
  void let_end() {
    const std::lock_guard lock(mutex_);
    limit_ = can::Time::max();
    parked_ = false;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  can::Time limit_{0};
  bool parked_ = false;
};

}  // namespace given
