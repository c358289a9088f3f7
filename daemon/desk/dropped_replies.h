#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "daemon/desk/gateway_events.h"

namespace cansyncd {

/// Replies that could not be delivered, summed up for a while: an event for each would be held back, and
/// their number lost. Not thread safe.
class DroppedReplies {
 public:
  /// Between two events.
  static constexpr std::chrono::seconds kPeriod{1};

  void add(std::uint64_t count) noexcept { count_ += count; }

  /// All that were added and not told yet, when it is time to tell them; else 0.
  std::uint64_t take(SteadyTime now) noexcept {
    if (count_ == 0 || now < next_) return 0;
    next_ = now + kPeriod;
    return std::exchange(count_, 0);
  }

  /// When `take` has something; nothing: there is nothing to tell.
  std::optional<SteadyTime> next() const noexcept {
    return count_ == 0 ? std::nullopt : std::optional(next_);
  }

 private:
  std::uint64_t count_ = 0;
  SteadyTime next_;
};

}  // namespace cansyncd
