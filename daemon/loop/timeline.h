#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "can/bus.h"
#include "daemon/loop/leading_edges.h"
#include "daemon/loop/moment.h"
#include "sync/phase_lock.h"

namespace cansyncd {

/// When each SYNC edge is due, on the clock of the bus. By itself SYNC n is due at start + n * interval, for
/// ever; with a phase lock the edges follow an input; one that is led takes those of another timeline, with
/// their numbers, each once it has passed there. Realtime thread; nothing allocates or throws.
class Timeline {
 public:
  /// What became of edges that were missed.
  struct Missed {
    IntervalNumber count = 0;  ///< edges skipped
    bool wait = false;         ///< the next edge is still to be waited for
  };

  /// `follow`: settings of the phase lock; empty: the timeline stands by itself. `led`: by which it is led
  /// instead; null: by none; must outlive the timeline.
  Timeline(can::Time interval, const std::optional<sync_line::PhaseLockSettings>& follow,
           const LeadingEdges* led = nullptr) noexcept
      : interval_(interval), tolerance_(interval / 2), led_(led) {
    if (!follow) return;
    lock_.emplace(*follow);
    // An interval may be shorter by the greatest step; two edges stay half an interval apart all the same.
    tolerance_ -= follow->greatest_step;
  }

  /// Sets edge 0.
  void begin(can::Time first) noexcept {
    due_ = first;
    if (led_ != nullptr) next_ = led_->passed + 1;
    if (lock_) lock_->begin(first);
  }

  /// The next edge.
  can::Time due() const noexcept {
    if (led_ == nullptr) return due_;
    return led_->passed >= next_ ? led_->newest : led_->next;
  }
  /// Number of the interval that the next edge begins.
  IntervalNumber next() const noexcept { return next_; }

  /// `n` edges have passed.
  void advance(IntervalNumber n = 1) noexcept {
    next_ += n;
    if (lock_) {
      lock_->advance(n);
      due_ = lock_->next();
    } else {
      due_ += static_cast<can::Time::rep>(n) * interval_;
    }
  }

  /// The edge has just been made, at `at`: no other one comes within half an interval of it.
  void made(can::Time at) noexcept { made_ = at; }

  /// Skips edges for which `now` is more than half an interval late, and one that would follow
  /// within half an interval on an edge that was held up; none is made up for.
  Missed skip_missed(can::Time now) noexcept {
    if (led_ != nullptr) return skip_led(now);
    const can::Time period = lock_ ? can::Time(std::llround(lock_->period())) : interval_;
    Missed missed;
    for (can::Time late = now - due_; late > tolerance_; late = now - due_) {
      const auto n = static_cast<IntervalNumber>((late - tolerance_ + period - can::Time(1)) / period);
      missed.count += n;
      advance(n);
    }
    if (made_ && std::max(due_, now) - *made_ < tolerance_) {
      ++missed.count;
      advance();
    }
    missed.wait = due_ > now;
    return missed;
  }

  /// The phase lock the edges follow; null when the timeline stands by itself.
  sync_line::PhaseLock* lock() noexcept { return lock_ ? &*lock_ : nullptr; }

 private:
  /// Which edges have passed says who leads.
  Missed skip_led(can::Time now) noexcept {
    Missed missed;
    const auto skip = [&](IntervalNumber count) {
      missed.count += count;
      next_ += count;
    };
    if (led_->passed > next_) skip(led_->passed - next_);
    if (led_->passed == next_ && now - led_->newest > tolerance_) skip(1);
    if (led_->passed == next_ && made_ && now - *made_ < tolerance_) skip(1);
    missed.wait = led_->passed < next_;
    return missed;
  }

  const can::Time interval_;
  can::Time tolerance_;
  const LeadingEdges* led_;
  std::optional<sync_line::PhaseLock> lock_;
  std::optional<can::Time> made_;  ///< the last edge, as it was made
  can::Time due_{0};
  IntervalNumber next_ = 0;
};

}  // namespace cansyncd
