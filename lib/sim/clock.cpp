#include "sim/clock.h"

#include <algorithm>
#include <ctime>

#include "system/clock.h"

namespace sim {

can::Time LineClock::now() const noexcept {
  if (kind_ == ClockKind::virtual_time) return virtual_now_;
  return sys::read_clock(CLOCK_MONOTONIC);
}

bool LineClock::sleep_until(can::Time instant) noexcept {
  if (kind_ == ClockKind::virtual_time) {
    virtual_now_ = std::max(virtual_now_, instant);
    return true;
  }
  const timespec time = sys::to_timespec(std::max(instant, can::Time{0}));
  return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr) == 0;
}

}  // namespace sim
