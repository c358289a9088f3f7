#include "layer2/dds/validate.h"

#include <fmt/format.h>

#include "can/frame.h"

namespace layer2::dds {

using gateway::dds::Denial;
using gateway::dds::Problem;

Problem check(const layer2_SendRequest& request) {
  const layer2_CanFrame& frame = request.content;
  const std::uint32_t largest = frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (frame.identifier > largest) {
    return Denial{
        gateway_CAUSE_FIELD,
        fmt::format("content.identifier 0x{:X}: out of range; allowed 0..0x{:X}{}", frame.identifier, largest,
                    frame.extended ? "" : ", or with extended up to 0x1FFFFFFF")};
  }
  if (frame.length > 8)
    return Denial{gateway_CAUSE_LENGTH,
                  fmt::format("content.length {}: out of range; allowed 0..8", frame.length)};
  if (request.timeout > kMaximumTimeoutMs) {
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("timeout {} ms: out of range; allowed 0..{} ms, 0 = the daemon's default",
                              request.timeout, kMaximumTimeoutMs)};
  }
  return std::nullopt;
}

Problem explain(Refusal refusal, std::uint16_t queue) {
  switch (refusal) {
    case Refusal::none:
      return std::nullopt;
    case Refusal::queue_full:
      return Denial{
          gateway_CAUSE_QUEUE_FULL,
          fmt::format("queue full: at most {} frames may wait to be sent; try again when one has been",
                      queue)};
    case Refusal::bad_frame:
      return Denial{gateway_CAUSE_FIELD,
                    "content: no frame that can be sent; allowed are data and remote frames with 0..8 bytes"};
    case Refusal::not_running:
      return Denial{gateway_CAUSE_WRONG_STATE, "in stop nothing is sent; let it run first"};
    case Refusal::stopped:
      break;
  }
  return Denial{gateway_CAUSE_STOPPING, "the daemon is being stopped; send again when it runs"};
}

}  // namespace layer2::dds
