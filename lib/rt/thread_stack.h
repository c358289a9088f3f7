#pragma once

#include <cstddef>

namespace rt {

/// Makes `bytes` the stack size of every thread created from now on without a size of its own, those of
/// libraries included; false when the system refuses the size, or no thread starts with it because
/// the libraries' thread-local data do not fit, and nothing has changed.
///
/// With all memory locked every stack counts in full, 8 MiB each by default. At least 128 KiB; call at the
/// start of the program, on the main thread.
bool set_default_stack_size(std::size_t bytes) noexcept;

/// Bytes of each new thread's stack that the C library takes for the thread-local data of the program and
/// the libraries it has now; a stack of a given size has so much less for its thread's work. Any thread, not
/// a realtime one (it locks the list of libraries).
std::size_t thread_local_bytes() noexcept;

}  // namespace rt
