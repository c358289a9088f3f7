#include "sim/clock.h"

#include <algorithm>
#include <ctime>

namespace sim {
namespace {

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;

}  // namespace

can::Time LineClock::now() const noexcept {
  if (kind_ == ClockKind::virtual_time) return virtual_now_;
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return can::Time(time.tv_sec * kNanosecondsPerSecond + time.tv_nsec);
}

bool LineClock::sleep_until(can::Time instant) noexcept {
  if (kind_ == ClockKind::virtual_time) {
    virtual_now_ = std::max(virtual_now_, instant);
    return true;
  }
  const std::int64_t nanoseconds = std::max<std::int64_t>(instant.count(), 0);
  const timespec time{nanoseconds / kNanosecondsPerSecond, nanoseconds % kNanosecondsPerSecond};
  return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == 0;
}

}  // namespace sim
