#include "dds/key_guard.h"

#include <algorithm>
#include <new>
#include <utility>

namespace gateway::dds {

dds_return_t KeyGuard::install(dds_entity_t topic) noexcept {
  dds_topic_filter filter = {};
  filter.mode = DDS_TOPIC_FILTER_SAMPLE_SAMPLEINFO_ARG;
  filter.f.sample_sampleinfo_arg = &KeyGuard::accept;
  filter.arg = this;
  return dds_set_topic_filter_extended(topic, &filter);
}

bool KeyGuard::accept(const void* sample, const dds_sample_info_t* info, void* guard) noexcept {
  auto& self = *static_cast<KeyGuard*>(guard);
  const std::lock_guard lock(self.mutex_);
  try {
    if (self.let_in(sample, *info)) return true;
  } catch (const std::bad_alloc&) {
    // No memory for another key: it is one too many.
    ++self.dropped_;
  }
  self.signal_.raise();
  return false;
}

bool KeyGuard::let_in(const void* sample, const dds_sample_info_t& info) {
  const Content content = look_(sample);
  if (content.elsewhere) {
    ++elsewhere_;
    return false;
  }
  if (!known_or_allowed(info.publication_handle, info.instance_handle)) {
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

bool KeyGuard::known_or_allowed(dds_instance_handle_t writer, dds_instance_handle_t key) {
  const auto known = keys_.find(writer);
  if (known != keys_.end() && known->second.contains(key)) return true;
  if (count_ >= kKeys || (known != keys_.end() && known->second.size() >= kKeysPerWriter)) return false;
  keys_[writer].insert(key);
  ++count_;
  return true;
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
  std::erase_if(keys_, [&](const auto& entry) {
    if (std::find(living.begin(), living.end(), entry.first) != living.end()) return false;
    count_ -= entry.second.size();
    return true;
  });
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
