#pragma once

#include <cansync/client.h>
#include <cansync/function_blocks/types.h>

#include <chrono>

#include "dds/participant.h"
#include "support/long_wait.h"

/// What the tests of all function blocks share.
namespace cansync::client::function_blocks {

inline Options options_at(const gateway::dds::ParticipantOptions& place) {
  return {.domain = place.domain,
          .bus = place.partition,
          .interface = place.interface,
          .client_name = "blocks",
          .xml = place.xml,
          .wait = gateway::kLongWait};
}

/// Calls a block as a PLC program does, with the time of the test.
template <class Block>
void cycle(Block& block, Clock::time_point now) {
  if constexpr (requires { block.call(now); }) {
    block.call(now);
  } else {
    block.call();
  }
}

/// Calls `step` until `condition` holds; false when it does not within `kLongWait`.
template <class Step, class Condition>
bool repeat_until(Step&& step, Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  for (step(); !condition(); step()) {
    if (std::chrono::steady_clock::now() > end) return false;
  }
  return true;
}

}  // namespace cansync::client::function_blocks
