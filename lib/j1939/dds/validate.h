#pragma once

#include <cstdint>

#include "dds/denial.h"
#include "j1939.h"
#include "j1939/order.h"

/// Every range check of what comes in over DDS. A problem text names field, value, allowed range and, where
/// there is one, the remedy; it fits `gateway_TEXT`. Gateway thread only (allocates).
namespace j1939::dds {

/// Longest monitoring time a request may ask for: one hour.
inline constexpr std::uint32_t kMaximumTimeoutMs = 3'600'000;

/// Nothing, or why the request is refused. What passes can be converted (convert.h) without loss.
gateway::dds::Problem check(const j1939_MessageRequest& request);

/// A refusal of the node, with limits and remedy; nothing for Refusal::none. `queue` is the configured number
/// of orders that may wait.
gateway::dds::Problem explain(Refusal refusal, std::uint16_t queue, std::size_t most);

}  // namespace j1939::dds
