#include "cansync/sim/drive_sync.h"

#include <algorithm>
#include <limits>

namespace sim {

DriveSync::DriveSync(cansync::Duration interval, cansync::Duration lock_time,
                     std::uint32_t missing_until_lost) noexcept
    : interval_(interval),
      on_time_(interval + interval / 2),
      // n missing edges: the next one comes n + 1 intervals after the last.
      silence_(interval * (std::max(missing_until_lost, 2u) + 1LL) - interval / 2),
      lock_time_(lock_time) {}

std::uint32_t DriveSync::edge(can::Time now, bool activated) noexcept {
  const cansync::Duration elapsed = now - last_;
  std::uint32_t intervals = 1;
  if (!seen_ || elapsed < interval_ / 2) {
    intervals = 0;
  } else if (elapsed >= on_time_) {
    const auto rounded = (elapsed + interval_ / 2) / interval_;
    intervals =
        static_cast<std::uint32_t>(std::min<std::int64_t>(rounded, std::numeric_limits<std::int32_t>::max()));
    missed_ += intervals - 1;
    if (elapsed > silence_) lose();
  }
  seen_ = true;
  last_ = now;
  if (!activated) {
    synchronized_ = false;
    locking_ = false;
  } else if (!locking_) {
    locking_ = true;
    locking_since_ = now;
  }
  if (locking_ && !synchronized_) synchronized_ = now - locking_since_ >= lock_time_;
  return intervals;
}

void DriveSync::lose() noexcept {
  loss_ = loss_ || synchronized_;
  synchronized_ = false;
  locking_ = false;
}

void DriveSync::reset() noexcept {
  seen_ = false;
  locking_ = false;
  synchronized_ = false;
  loss_ = false;
}

}  // namespace sim
