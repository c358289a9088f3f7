#pragma once

#include <malloc.h>

#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CANSYNC_SANITIZED_HEAP 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define CANSYNC_SANITIZED_HEAP 1
#endif
#endif
#ifdef CANSYNC_SANITIZED_HEAP
// Of the sanitizers' runtime; its header sanitizer/allocator_interface.h does not come with g++.
extern "C" std::size_t
__sanitizer_get_current_allocated_bytes() noexcept;  // NOLINT(bugprone-reserved-identifier)
#endif

namespace cansyncd::support {

/// True when a sanitizer's allocator is at work. What it keeps back makes resident memory grow.
#ifdef CANSYNC_SANITIZED_HEAP
inline constexpr bool kSanitizedHeap = true;
#else
inline constexpr bool kSanitizedHeap = false;
#endif

/// Bytes of the heap that are allocated now, by all threads of this process. Unlike resident memory it does
/// not count what is free and kept by the allocator.
inline std::size_t heap_in_use() noexcept {
#ifdef CANSYNC_SANITIZED_HEAP
  return __sanitizer_get_current_allocated_bytes();
#else
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
#endif
}

}  // namespace cansyncd::support
