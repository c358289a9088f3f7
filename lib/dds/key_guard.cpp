#include "dds/key_guard.h"

#include <algorithm>
#include <new>
#include <utility>

namespace cansync::dds {

dds_return_t KeyGuard::install(dds_entity_t topic) noexcept {
  dds_topic_filter filter = {};
  filter.mode = DDS_TOPIC_FILTER_SAMPLEINFO_ARG;
  filter.f.sampleinfo_arg = &KeyGuard::accept;
  filter.arg = this;
  return dds_set_topic_filter_extended(topic, &filter);
}

bool KeyGuard::accept(const dds_sample_info_t* info, void* guard) noexcept {
  auto& self = *static_cast<KeyGuard*>(guard);
  const std::lock_guard lock(self.mutex_);
  try {
    if (self.known_or_allowed(info->publication_handle, info->instance_handle)) return true;
  } catch (const std::bad_alloc&) {
    // No memory for another key: it is one too many.
  }
  ++self.dropped_;
  self.signal_.raise();
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

void KeyGuard::keep(std::span<const dds_instance_handle_t> living) {
  const std::lock_guard lock(mutex_);
  std::erase_if(keys_, [&](const auto& entry) {
    if (std::find(living.begin(), living.end(), entry.first) != living.end()) return false;
    count_ -= entry.second.size();
    return true;
  });
}

std::uint64_t KeyGuard::take_dropped() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(dropped_, 0);
}

}  // namespace cansync::dds
