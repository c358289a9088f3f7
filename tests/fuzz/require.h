#pragma once

#include <cstdio>
#include <cstdlib>

/// Ends the program, which the fuzzer and ctest count as a failure, unless `holds`; `what` says what should.
namespace fuzz {

inline void require(bool holds, const char* what) noexcept {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n", what);
  std::abort();
}

}  // namespace fuzz
