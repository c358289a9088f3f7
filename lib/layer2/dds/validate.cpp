#include "layer2/dds/validate.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "can/frame.h"
#include "dds/enumerator.h"
#include "text/counts.h"

namespace layer2::dds {

using gateway::dds::Denial;
using gateway::dds::Problem;

namespace {

constexpr std::uint32_t kShortestPeriodUs = 100;
constexpr std::uint32_t kLongestPeriodUs = 3'600'000'000;

Problem check(const layer2_CanFrame& frame) {
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
  return std::nullopt;
}

Problem check_timer(const layer2_ControlRequest& request) {
  if (auto problem = check(request.content)) return problem;
  if (request.period < kShortestPeriodUs || request.period > kLongestPeriodUs) {
    return Denial{gateway_CAUSE_FIELD, fmt::format("period {} us: out of range; allowed {}..{} us",
                                                   request.period, kShortestPeriodUs, kLongestPeriodUs)};
  }
  if (request.phase > kLongestPeriodUs) {
    return Denial{gateway_CAUSE_FIELD, fmt::format("phase {} us: out of range; allowed 0..{} us",
                                                   request.phase, kLongestPeriodUs)};
  }
  return std::nullopt;
}

Problem check_number(const layer2_ControlRequest& request) {
  if (request.number >= 1 && request.number <= Timers::kMost) return std::nullopt;
  return Denial{gateway_CAUSE_FIELD,
                fmt::format("number {}: no such timer; allowed 1..{}", request.number, Timers::kMost)};
}

Problem check_bytes(const layer2_ControlRequest& request) {
  if (request.size < 1 || request.size > ControlOrder::kMostBytes) {
    return Denial{gateway_CAUSE_LENGTH, fmt::format("size {}: out of range; allowed 1..{}", request.size,
                                                    ControlOrder::kMostBytes)};
  }
  if (request.address + request.size <= DataMapping::kBytes) return std::nullopt;
  return Denial{gateway_CAUSE_ADDRESS,
                fmt::format("address {} and size {}: end after the image; allowed 0..{} together",
                            request.address, request.size, DataMapping::kBytes)};
}

}  // namespace

Problem check(const layer2_ControlRequest& request) {
  const std::int64_t kind = gateway::dds::raw_number_of(request.kind);
  switch (kind) {
    case layer2_CONTROL_START_TIMER:
    case layer2_CONTROL_STOP_TIMER:
      return check_number(request);
    case layer2_CONTROL_SET_TIMER: {
      auto problem = check_number(request);
      return problem ? std::move(problem) : check_timer(request);
    }
    case layer2_CONTROL_WRITE_IMAGE:
      return check_bytes(request);
    default:
      break;
  }
  if (kind >= layer2_CONTROL_RUN && kind <= layer2_CONTROL_WRITE_IMAGE) return std::nullopt;
  return Denial{gateway_CAUSE_KIND, fmt::format("kind {}: unknown to this daemon", kind)};
}

Problem check(const layer2_SendRequest& request) {
  if (auto problem = check(request.content)) return problem;
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
      return Denial{gateway_CAUSE_QUEUE_FULL,
                    fmt::format("queue full: at most {} may wait to be sent; try again when one has been",
                                text::counted(queue, "frame"))};
    case Refusal::bad_frame:
      return Denial{gateway_CAUSE_FIELD,
                    "content: no frame that can be sent; allowed are data and remote frames with 0..8 bytes"};
    case Refusal::no_timer:
      return Denial{gateway_CAUSE_FIELD,
                    "number: that timer has nothing to send; set it first, or give it a [[timer]] section"};
    case Refusal::no_image:
      return Denial{gateway_CAUSE_MAPPING, "there is no process image; give the daemon [[mapped]] sections"};
    case Refusal::not_permitted:
      return Denial{gateway_CAUSE_RIGHT,
                    "the daemon may not reset the controller; give it the right CAP_NET_ADMIN"};
    case Refusal::no_controller:
      return Denial{
          gateway_CAUSE_BUS_UNAVAILABLE,
          "the controller cannot be reset: its interface is missing or down, or its driver does not do it"};
    case Refusal::reset_under_way:
      return Denial{gateway_CAUSE_QUEUE_FULL, "the controller is being reset"};
    case Refusal::not_running:
      return Denial{gateway_CAUSE_WRONG_STATE, "in stop nothing is sent; let it run first (cansync can run)"};
    case Refusal::stopped:
      break;
  }
  return Denial{gateway_CAUSE_STOPPING, "the daemon is being stopped; send again when it runs"};
}

}  // namespace layer2::dds
