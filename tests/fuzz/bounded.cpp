// Counts what the whole program allocates, where the address sanitizer tells it. Elsewhere nothing is counted.
#include "bounded.h"

#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define CANSYNC_COUNTS_ALLOCATIONS
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
#define CANSYNC_COUNTS_ALLOCATIONS
#endif

std::size_t fuzz::allocated = 0;

#ifdef CANSYNC_COUNTS_ALLOCATIONS

// Of sanitizer/allocator_interface.h, which Debian has for clang alone; gcc's library has it, too.
// NOLINTNEXTLINE(bugprone-reserved-identifier)
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*allocates)(const volatile void*, std::size_t),
                                                         void (*frees)(const volatile void*));

namespace {

void allocates(const volatile void* /*memory*/, std::size_t size) {
  fuzz::allocated += size;
}
void frees(const volatile void* /*memory*/) {}

[[maybe_unused]] const int kInstalled = __sanitizer_install_malloc_and_free_hooks(allocates, frees);

}  // namespace
#endif
