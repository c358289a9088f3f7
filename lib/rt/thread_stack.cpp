#include "rt/thread_stack.h"

#include <link.h>
#include <pthread.h>

namespace rt {
namespace {

/// A stack that is legal can still be too small for the thread-local data of the libraries that are loaded;
/// only the start of a thread tells.
bool threads_start() noexcept {
  pthread_t thread{};
  if (pthread_create(
          &thread, nullptr, [](void* nothing) { return nothing; }, nullptr) != 0)
    return false;
  return pthread_join(thread, nullptr) == 0;
}

}  // namespace

bool set_default_stack_size(std::size_t bytes) noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return false;
  std::size_t before = 0;
  bool done = pthread_attr_getstacksize(&attributes, &before) == 0 &&
              pthread_attr_setstacksize(&attributes, bytes) == 0 &&
              pthread_setattr_default_np(&attributes) == 0;
  if (done && !threads_start()) {
    done = false;
    if (pthread_attr_setstacksize(&attributes, before) == 0) (void)pthread_setattr_default_np(&attributes);
  }
  pthread_attr_destroy(&attributes);
  return done;
}

std::size_t thread_local_bytes() noexcept {
  std::size_t bytes = 0;
  ::dl_iterate_phdr(
      [](dl_phdr_info* library, std::size_t, void* sum) {
        for (unsigned i = 0; i < library->dlpi_phnum; ++i) {
          const auto& header = library->dlpi_phdr[i];
          if (header.p_type == PT_TLS) *static_cast<std::size_t*>(sum) += header.p_memsz + header.p_align;
        }
        return 0;
      },
      &bytes);
  return bytes;
}

}  // namespace rt
