#include "rt/thread_stack.h"

#include <pthread.h>

namespace rt {

bool set_default_stack_size(std::size_t bytes) noexcept {
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) != 0) return false;
  const bool done =
      pthread_attr_setstacksize(&attributes, bytes) == 0 && pthread_setattr_default_np(&attributes) == 0;
  pthread_attr_destroy(&attributes);
  return done;
}

}  // namespace rt
