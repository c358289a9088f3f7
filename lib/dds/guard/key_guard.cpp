#include "dds/guard/key_guard.h"

#include <algorithm>
#include <new>
#include <utility>

namespace gateway::dds {

bool KeyGuard::accept(const void* sample, const dds_sample_info_t& info) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    if (let_in(sample, info)) return true;
  } catch (const std::bad_alloc&) {
    // No memory for another key: it is one too many.
    ++dropped_;
  }
  signal_.raise();
  return false;
}

void KeyGuard::forget() noexcept {
  const std::lock_guard lock(mutex_);
  keys_.keep({});
  waiting_.clear();
  samples_ = bytes_ = 0;
  turned_away_.clear();
}

bool KeyGuard::let_in(const void* sample, const dds_sample_info_t& info) {
  const Content content = look_(sample);
  if (content.elsewhere) {
    ++elsewhere_;
    return false;
  }
  if (!keys_.known_or_allowed(info.publication_handle, info.instance_handle)) {
    ++dropped_;
    return false;
  }
  Waiting& own = waiting_[info.instance_handle];
  // One that is too large by itself is let in when nothing else waits: its client is told why it is refused.
  const bool fits = samples_ < kSamples && own.samples < kSamplesPerKey &&
                    (own.samples == 0 || own.bytes + content.bytes <= kBytesPerKey) &&
                    (bytes_ == 0 || bytes_ + content.bytes <= kBytes);
  if (fits) {
    ++own.samples;
    own.bytes += content.bytes;
    ++samples_;
    bytes_ += content.bytes;
    return true;
  }
  if (own.turned_away < kTurnedAwayPerKey && turned_away_.size() < kTurnedAway) {
    turned_away_.push_back({{content.key, info.publication_handle}, info.instance_handle});
    ++own.turned_away;
  } else {
    ++forgotten_;
  }
  forget_if_idle(info.instance_handle);
  return false;
}

void KeyGuard::forget_if_idle(dds_instance_handle_t key) {
  const auto found = waiting_.find(key);
  if (found != waiting_.end() && found->second.samples == 0 && found->second.turned_away == 0)
    waiting_.erase(found);
}

void KeyGuard::taken(dds_instance_handle_t key, std::size_t bytes) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = waiting_.find(key);
  if (found == waiting_.end() || found->second.samples == 0) return;
  --found->second.samples;
  --samples_;
  found->second.bytes -= std::min(bytes, found->second.bytes);
  bytes_ -= std::min(bytes, bytes_);
  forget_if_idle(key);
}

void KeyGuard::keep(std::span<const dds_instance_handle_t> living) {
  const std::lock_guard lock(mutex_);
  keys_.keep(living);
}

std::uint64_t KeyGuard::take_elsewhere() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(elsewhere_, 0);
}

std::uint64_t KeyGuard::take_dropped() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(dropped_, 0);
}

std::vector<KeyGuard::TurnedAway> KeyGuard::take_turned_away(std::size_t most) {
  std::vector<TurnedAway> taken;
  const std::lock_guard lock(mutex_);
  while (taken.size() < most && !turned_away_.empty()) {
    const Refused& oldest = turned_away_.front();
    taken.push_back(oldest.what);
    --waiting_.at(oldest.key).turned_away;
    forget_if_idle(oldest.key);
    turned_away_.pop_front();
  }
  return taken;
}

std::uint64_t KeyGuard::take_forgotten() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(forgotten_, 0);
}

}  // namespace gateway::dds
