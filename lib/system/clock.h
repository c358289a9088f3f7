#pragma once

#include <chrono>
#include <ctime>

/// The clocks of the system. Realtime safe: no system call where the kernel offers them in user space (vDSO).
namespace sys {

/// A span as the system's calls take it; not negative.
constexpr timespec to_timespec(std::chrono::nanoseconds span) noexcept {
  const auto seconds = std::chrono::floor<std::chrono::seconds>(span);
  return {static_cast<time_t>(seconds.count()), static_cast<long>((span - seconds).count())};
}

/// Since the clock's beginning.
constexpr std::chrono::nanoseconds from_timespec(const timespec& time) noexcept {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// CLOCK_MONOTONIC, CLOCK_REALTIME or another that there is.
inline std::chrono::nanoseconds read_clock(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return from_timespec(now);
}

}  // namespace sys
