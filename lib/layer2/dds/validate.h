#pragma once

#include <cstdint>
#include <string>

#include "dds/denial.h"
#include "layer2.h"
#include "layer2/module.h"

/// Every range check of what comes in over DDS. A problem text names field, value, allowed range and, where
/// there is one, the remedy; it fits `gateway_TEXT`. Gateway thread only (allocates).
namespace layer2::dds {

/// Longest monitoring time a request may ask for: one hour.
inline constexpr std::uint32_t kMaximumTimeoutMs = 3'600'000;

/// Nothing, or why the request is refused. What passes can be converted (convert.h) without loss.
gateway::dds::Problem check(const layer2_SendRequest& request);
gateway::dds::Problem check(const layer2_ControlRequest& request);
gateway::dds::Problem check(const layer2_ObjectRequest& request);

/// A refusal of the station, with limits and remedy; nothing for Refusal::none. `queue` is the configured
/// number of orders that may wait.
gateway::dds::Problem explain(Refusal refusal, std::uint16_t queue);

}  // namespace layer2::dds
