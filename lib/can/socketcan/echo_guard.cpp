#include "can/socketcan/echo_guard.h"

namespace can {
namespace {

/// Looks come at the same places of each interval, by about this much.
constexpr Time kLookJitter = std::chrono::microseconds(100);

}  // namespace

bool EchoGuard::may_send(Time now) const noexcept {
  if (interval_ == Time{0}) return true;
  return !held_ && now >= resume_ && (proven_ || one_shot_ || count_ == 0);
}

void EchoGuard::handed_over(const Frame& frame) noexcept {
  if (interval_ == Time{0}) return;
  if (count_ == 0) undated_ = true;
  if (count_ == kMost) forget_first(1);  // looks that left frames behind do not judge
  frames_[(first_ + count_) % kMost] = frame;
  ++count_;
}

void EchoGuard::begin_look(Time at, bool one_shot) noexcept {
  look_ = at;
  one_shot_ = one_shot;
  if (undated_) progress_ = at;
  undated_ = false;
}

void EchoGuard::echo(const Frame& frame) noexcept {
  if (interval_ == Time{0}) return;
  progress_ = look_;
  proven_ = true;
  refused_ = in_vain_ = false;
  given_up_ = 0;
  // The controller sends in the order in which it was given them: those before this one were on the bus.
  for (std::size_t i = 0; i < count_; ++i) {
    if (outstanding(i) != frame) continue;
    forget_first(i + 1);
    break;
  }
  if (held_ && count_ != 0) return;
  held_ = false;
  resume_ = Time{0};
  delivery_ = Delivery::normal;
}

void EchoGuard::end_look(bool everything) noexcept {
  if (!everything || interval_ == Time{0}) return;
  if (refused_ && given_up_ != 0) {
    // It is not as one-shot as it says: what was given up stands in its queue.
    held_ = true;
    delivery_ = delivery_ == Delivery::normal ? Delivery::unacknowledged : delivery_;
    return;
  }
  if (count_ == 0 || !silent_for(1)) return;
  if (one_shot_ && !refused_) return give_up();
  held_ = true;
  if (silent_for(2) && delivery_ == Delivery::normal) delivery_ = Delivery::unacknowledged;
}

bool EchoGuard::silent_for(unsigned intervals) const noexcept {
  return look_ - progress_ >= intervals * interval_ - kLookJitter;
}

/// One-shot: each was tried once, and is gone.
void EchoGuard::give_up() noexcept {
  unacknowledged_ += count_;
  count_ = 0;
  held_ = false;
  // One alone may have lost the bus to another node's frame.
  if (++given_up_ >= 2) delivery_ = Delivery::unacknowledged;
}

void EchoGuard::emptied(Time now) noexcept {
  unacknowledged_ += count_;
  const bool nothing_new = count_ == 0 && !held_;
  count_ = 0;
  proven_ = held_ = refused_ = false;
  given_up_ = 0;
  if (nothing_new || delivery_ == Delivery::normal) return;
  delivery_ = Delivery::unacknowledged;
  if (in_vain_) resume_ = now + kPause;
  in_vain_ = true;
}

void EchoGuard::forget_first(std::size_t count) noexcept {
  first_ = (first_ + count) % kMost;
  count_ -= count;
}

}  // namespace can
