#include "daemon/loop/wall_clock.h"

#include <ctime>

#include "system/clock.h"

namespace cansyncd {

can::Time read_realtime_clock() noexcept {
  return sys::read_clock(CLOCK_REALTIME);
}

}  // namespace cansyncd
