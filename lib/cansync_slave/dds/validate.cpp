#include "cansync_slave/dds/validate.h"

#include <fmt/format.h>

namespace cansync_slave::dds {

using gateway::dds::Denial;

gateway::dds::Problem check(const cansync_slave_ActualRelease& release) {
  constexpr unsigned kMostValid = 0x0F;
  if (release.telegram != 1 && release.telegram != 2)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("telegram {}: out of range; allowed 1 or 2", release.telegram)};
  if (release.valid > kMostValid)
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("valid 0x{:02X}: out of range; allowed 0..0x0F", release.valid)};
  if (release.wait_intervals > kMostWaitIntervals)
    return Denial{gateway_CAUSE_FIELD, fmt::format("wait_intervals {}: out of range; allowed 0..{}, 0 = 1",
                                                   release.wait_intervals, kMostWaitIntervals)};
  return std::nullopt;
}

}  // namespace cansync_slave::dds
