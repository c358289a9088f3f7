#pragma once

#include <cstdint>

#include "cansync_slave.h"
#include "dds/denial.h"

/// Every range check of what comes in over DDS. A problem text names field, value and allowed range; it fits
/// `gateway_TEXT`. Gateway thread only (allocates).
namespace cansync_slave::dds {

/// Longest that a release may wait to be asked for, in intervals.
inline constexpr std::uint32_t kMostWaitIntervals = 1000;

/// Nothing, or why the release is refused. A sample that gives the telegram up is not to be checked.
gateway::dds::Problem check(const cansync_slave_ActualRelease& release);

/// Nothing, or why the command is refused: kind, mode, slave or mapping.
gateway::dds::Problem check(const cansync_slave_SlaveCommand& command);

/// Nothing, or why what an application says is refused.
gateway::dds::Problem check(const cansync_slave_ApplicationAnswer& answer);

}  // namespace cansync_slave::dds
