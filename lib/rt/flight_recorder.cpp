#include "rt/flight_recorder.h"

#include <algorithm>

namespace rt {

FlightRecorder::FlightRecorder(std::size_t entries, std::uint64_t intervals_after)
    : ring_(std::max<std::size_t>(entries, 1)), intervals_after_(intervals_after) {}

bool FlightRecorder::recording() noexcept {
  if (frozen_.load(std::memory_order_acquire)) return false;
  if (saved_) {
    saved_ = false;
    count_ = 0;
  }
  return true;
}

void FlightRecorder::record(const FlightEntry& entry) noexcept {
  if (recording()) ring_[count_++ % ring_.size()] = entry;
}

FlightRecorder::Shown FlightRecorder::fault(const FlightTrigger& trigger) noexcept {
  const bool records = recording();
  if (!records || pending_) {
    count_fault();
    return records ? Shown::another : Shown::none;
  }
  pending_ = true;
  left_ = intervals_after_;
  trigger_ = trigger;
  return Shown::own;
}

void FlightRecorder::finish() noexcept {
  if (recording() && pending_) freeze();
}

void FlightRecorder::begin_interval(const FlightTrigger& now) noexcept {
  const bool requested =
      requested_.load(std::memory_order_relaxed) && requested_.exchange(false, std::memory_order_relaxed);
  if (!recording() || pending_) {
    // The recording that is under way answers the request.
    if (requested) further_.fetch_add(1, std::memory_order_relaxed);
    if (pending_ && left_-- == 0) freeze();
    return;
  }
  if (!requested) return;
  // Asked for is what came before: nothing is waited for.
  trigger_ = now;
  freeze();
}

void FlightRecorder::freeze() noexcept {
  pending_ = false;
  saved_ = true;
  frozen_.store(true, std::memory_order_release);
  signal_.signal();
}

bool FlightRecorder::wait_frozen(std::chrono::milliseconds timeout) noexcept {
  if (!frozen_.load(std::memory_order_acquire)) (void)signal_.wait(timeout);
  return frozen_.load(std::memory_order_acquire);
}

std::vector<FlightEntry> FlightRecorder::entries() const {
  const std::size_t size = ring_.size();
  const auto kept = static_cast<std::size_t>(std::min<std::uint64_t>(count_, size));
  std::vector<FlightEntry> out;
  out.reserve(kept);
  for (std::uint64_t i = count_ - kept; i < count_; ++i) out.push_back(ring_[i % size]);
  return out;
}

}  // namespace rt
