#include "cansync/process_data/reference_release.h"

#include <algorithm>
#include <utility>

namespace cansync {

void ReferenceRelease::stop() noexcept {
  pending_count_ = 0;
  remaining_ = 0;
  watched_ = false;
  begins_before_ = 0;
  hold_wanted_ = 0;
  status_.state = State::stopped;
  status_.cause = Cause::none;
  told_released_ = false;
  quiet_until_ = 0;
  too_old_quiet_until_ = 0;
}

bool ReferenceRelease::add(const ReferenceUpdate& update) noexcept {
  if (pending_count_ == kPendingUpdates) return false;
  pending_[pending_count_++] = update;
  return true;
}

void ReferenceRelease::withdraw(std::uint32_t hold) noexcept {
  pending_count_ = 0;
  watched_ = false;
  if (hold != 0 && status_.state == State::held) return;
  hold_wanted_ = status_.state == State::released ? hold : 0;
  if (hold_wanted_ == 0) end(Cause::withdrawn);
}

void ReferenceRelease::mapping_changed() noexcept {
  if (forget(Cause::mapping_changed)) ++status_.mapping_changed;
}

void ReferenceRelease::bus_lost() noexcept {
  (void)forget(Cause::bus_lost);
}

bool ReferenceRelease::forget(Cause cause) noexcept {
  const bool waited = std::exchange(pending_count_, 0) != 0;
  watched_ = false;
  hold_wanted_ = 0;
  if (status_.state == State::stopped) {
    if (waited) status_.cause = cause;
    return false;
  }
  end(cause);
  return true;
}

void ReferenceRelease::end(Cause cause) noexcept {
  remaining_ = 0;
  end_cause_ = cause;
  hold_until_ = 0;
  if (status_.state == State::held) status_.cause = cause;
}

/// Values are for so many intervals in a row: those that were skipped are over.
void ReferenceRelease::skip_missed(IntervalNumber now) noexcept {
  const IntervalNumber missed = now > last_ + 1 ? now - last_ - 1 : 0;
  // A release that ended meanwhile is not held either.
  if (missed > remaining_) hold_wanted_ = 0;
  remaining_ -= static_cast<std::uint32_t>(std::min<IntervalNumber>(missed, remaining_));
  last_ = now;
}

std::optional<ReferenceUpdate> ReferenceRelease::next_due(IntervalNumber now) noexcept {
  skip_missed(now);
  for (std::size_t i = 0; i < pending_count_;) {
    if (pending_[i].from_interval > now) {
      ++i;
      continue;
    }
    ReferenceUpdate due = pending_[i];
    --pending_count_;
    for (std::size_t later = i; later < pending_count_; ++later) pending_[later] = pending_[later + 1];
    if (due.begins_before() != 0 && due.begins_before() <= now) {
      tell_came_too_old(now);
      continue;
    }
    if (due.from_interval != 0) {
      const IntervalNumber late = now - due.from_interval;
      if (late >= due.release_intervals) continue;
      due.release_intervals -= static_cast<std::uint32_t>(late);
    }
    return due;
  }
  return std::nullopt;
}

void ReferenceRelease::take(const ReferenceUpdate& due, IntervalNumber now) noexcept {
  if (status_.state == State::held) tell(MasterEvent::Code::references_released);
  remaining_ = due.release_intervals;
  end_cause_ = Cause::used_up;
  hold_wanted_ = 0;
  watched_ = too_old_after_ != 0;
  begins_before_ = due.begins_before();
  status_.state = State::released;
  status_.cause = Cause::none;
  status_.given = now;
  ++status_.updates;
}

bool ReferenceRelease::decide(IntervalNumber now) noexcept {
  if (begins_before_ != 0 && begins_before_ <= now) never_begin(now);
  if (watched_ && now - status_.given >= too_old_after_) grow_old();
  if (hold_wanted_ != 0) hold(now + hold_wanted_, Cause::withdrawn);
  if (status_.state == State::held && now >= hold_until_) {
    remaining_ = 0;
    status_.state = State::stopped;
    quiet_until_ = 0;  // the end of a hold is always told
  } else if (status_.state == State::released && remaining_ == 0) {
    status_.state = State::stopped;
    status_.cause = end_cause_;
  }
  tell_release(now);
  return status_.state != State::stopped;
}

/// The values in use grew too old before they were on the bus at all.
void ReferenceRelease::never_begin(IntervalNumber now) noexcept {
  begins_before_ = 0;
  watched_ = false;
  hold_wanted_ = 0;
  hold_until_ = 0;
  remaining_ = 0;
  end_cause_ = Cause::too_old;
  ++status_.too_old;
  tell_came_too_old(now);
}

/// Tells the first, and then at most one in `kQuietIntervals`: what is always late would fill the journal.
void ReferenceRelease::tell_came_too_old(IntervalNumber now) noexcept {
  if (now < too_old_quiet_until_) return;
  too_old_quiet_until_ = now + kQuietIntervals;
  tell(MasterEvent::Code::references_too_old);
}

void ReferenceRelease::grow_old() noexcept {
  watched_ = false;
  ++status_.too_old;
  tell(MasterEvent::Code::references_too_old, too_old_after_);
  if (status_.state != State::released || hold_wanted_ != 0) return;
  if (hold_too_old_ != 0) {
    hold(status_.given + too_old_after_ + hold_too_old_, Cause::too_old);
  } else {
    remaining_ = 0;
    end_cause_ = Cause::too_old;
  }
}

void ReferenceRelease::hold(IntervalNumber until, Cause cause) noexcept {
  hold_wanted_ = 0;
  hold_until_ = until;
  status_.state = State::held;
  status_.cause = cause;
  tell(MasterEvent::Code::references_held);
}

void ReferenceRelease::sent() noexcept {
  begins_before_ = 0;
  left_out();
}

void ReferenceRelease::left_out() noexcept {
  if (remaining_ > 0) --remaining_;
}

void ReferenceRelease::tell(MasterEvent::Code code, std::uint32_t expected) noexcept {
  listener_.event({code, std::nullopt, index(channel_) + 1, expected});
}

/// Tells the first change at once; a release that keeps stopping is told once in `kQuietIntervals`.
void ReferenceRelease::tell_release(IntervalNumber now) noexcept {
  const bool released = status_.state != State::stopped;
  if (told_released_ == released || (!released && now < quiet_until_)) return;
  if (!released) quiet_until_ = now + kQuietIntervals;
  told_released_ = released;
  tell(released ? MasterEvent::Code::references_released : MasterEvent::Code::references_stopped);
}

}  // namespace cansync
