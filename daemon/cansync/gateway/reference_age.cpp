#include "daemon/cansync/gateway/reference_age.h"

#include <fmt/format.h>

#include <algorithm>

namespace cansyncd {

using gateway::dds::Denial;

ReferenceAge::Verdict ReferenceAge::judge(std::int64_t source, const ClockReading& now) const {
  if (limit_.count() == 0) return {};
  constexpr std::int64_t kFar = std::int64_t{1} << 62;  // a peer may write anything
  const std::chrono::nanoseconds age(now.wall - std::clamp(source, now.wall - kFar, now.wall + kFar));
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(age).count();
  if (age < -limit_) {
    return {Denial{
        gateway_CAUSE_STALE,
        fmt::format(
            "written {} ms in the future: at most {} ms are allowed (failsafe.reference_max_age_ms); set the "
            "clocks of both computers",
            -milliseconds, limit_.count())}};
  }
  if (age > limit_) {
    return {Denial{
        gateway_CAUSE_STALE,
        fmt::format(
            "age {} ms: at most {} ms are allowed (failsafe.reference_max_age_ms); write fresh values, and set "
            "the clocks of both computers",
            milliseconds, limit_.count())}};
  }
  return {std::nullopt, first_interval_after(now.steady + (limit_ - age))};
}

/// Never 0, which would mean that there is no limit.
cansync::IntervalNumber ReferenceAge::first_interval_after(
    std::chrono::steady_clock::time_point instant) const noexcept {
  const auto ahead = std::chrono::duration_cast<can::Time>(instant.time_since_epoch()) - heard_.bus;
  const auto known = static_cast<std::int64_t>(heard_.interval);
  const std::int64_t intervals =
      ahead.count() >= 0 ? ahead / interval_ : -((-ahead + interval_ - can::Time(1)) / interval_);
  return static_cast<cansync::IntervalNumber>(std::max<std::int64_t>(known + intervals, 0) + 1);
}

}  // namespace cansyncd
