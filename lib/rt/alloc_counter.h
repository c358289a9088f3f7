#pragma once

#include <cstdint>

/// Counts what a realtime thread must not do. Linking this library into a test replaces operator new, the
/// malloc family, the pthread lock functions and write() of the whole program by counting ones.
namespace rt {

/// Calls of one thread since it started.
struct ThreadCalls {
  std::uint64_t allocations = 0;  ///< operator new, malloc, calloc, realloc, memalign and their like
  std::uint64_t locks = 0;        ///< pthread mutex and reader-writer locks taken or tried
  std::uint64_t writes = 0;       ///< write()
};

/// Calls of the calling thread so far.
ThreadCalls thread_calls() noexcept;

/// True when malloc, locks and write() are counted too. Under a sanitizer, which replaces these functions
/// itself, only operator new is.
bool counts_c_library() noexcept;

}  // namespace rt
