#include "dds/guard/owner_guard.h"

#include <new>
#include <utility>

namespace gateway::dds {

bool OwnerGuard::accept(const void* /*sample*/, const dds_sample_info_t& info) noexcept {
  const std::lock_guard lock(mutex_);
  try {
    if (keys_.known_or_allowed(info.publication_handle, info.instance_handle)) return true;
  } catch (const std::bad_alloc&) {
    // No memory for another key: it is one too many.
  }
  ++dropped_;
  signal_.raise();
  return false;
}

void OwnerGuard::keep(std::span<const dds_instance_handle_t> living) {
  const std::lock_guard lock(mutex_);
  keys_.keep(living);
}

std::uint64_t OwnerGuard::take_dropped() noexcept {
  const std::lock_guard lock(mutex_);
  return std::exchange(dropped_, 0);
}

}  // namespace gateway::dds
