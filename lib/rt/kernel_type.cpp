#include "rt/kernel_type.h"

#include <sys/utsname.h>

namespace rt {

std::string_view preemption_of(std::string_view version) noexcept {
  // The longer words contain the shortest.
  for (const std::string_view word : {"PREEMPT_RT", "PREEMPT_DYNAMIC", "PREEMPT"}) {
    if (version.find(word) != std::string_view::npos) return word;
  }
  return "no preemption";
}

std::string kernel_type() {
  utsname names{};
  if (::uname(&names) != 0) return "unknown";
  return std::string(names.release) + " (" + std::string(preemption_of(names.version)) + ")";
}

}  // namespace rt
