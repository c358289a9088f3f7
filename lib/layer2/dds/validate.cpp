#include "layer2/dds/validate.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "can/frame.h"
#include "dds/enumerator.h"
#include "text/counts.h"

namespace layer2::dds {

using gateway::dds::Denial;
using gateway::dds::Problem;

namespace {

std::string identifier_problem(std::string_view field, std::uint32_t identifier, bool extended) {
  const std::uint32_t largest = extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask;
  if (identifier <= largest) return {};
  return fmt::format("{} 0x{:X}: out of range; allowed 0..0x{:X}{}", field, identifier, largest,
                     extended ? "" : ", or with extended up to 0x1FFFFFFF");
}

constexpr std::uint32_t kShortestPeriodUs = 100;
constexpr std::uint32_t kLongestPeriodUs = 3'600'000'000;

Problem check(const layer2_CanFrame& frame, std::string_view member = "content") {
  auto text = identifier_problem(fmt::format("{}.identifier", member), frame.identifier, frame.extended);
  if (!text.empty()) return Denial{gateway_CAUSE_FIELD, std::move(text)};
  if (frame.length > 8)
    return Denial{gateway_CAUSE_LENGTH,
                  fmt::format("{}.length {}: out of range; allowed 0..8", member, frame.length)};
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

Problem check_settings(const layer2_ObjectRequest& request) {
  for (std::uint32_t i = 0; i < request.settings._length; ++i) {
    const layer2_ObjectSettings& settings = request.settings._buffer[i];
    if (settings.number >= MessageObjects::kMost) {
      return Denial{gateway_CAUSE_FIELD, fmt::format("settings[{}].number {}: no such object; allowed 0..{}",
                                                     i, settings.number, MessageObjects::kMost - 1)};
    }
    auto text =
        identifier_problem(fmt::format("settings[{}].identifier", i), settings.identifier, settings.extended);
    if (!text.empty()) return Denial{gateway_CAUSE_FIELD, std::move(text)};
    if (settings.timeout > kMaximumTimeoutMs) {
      return Denial{gateway_CAUSE_FIELD,
                    fmt::format("settings[{}].timeout {} ms: out of range; allowed 0..{} ms, 0 = never", i,
                                settings.timeout, kMaximumTimeoutMs)};
    }
  }
  return std::nullopt;
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
  if (kind >= layer2_CONTROL_RUN && kind <= layer2_CONTROL_CONFIGURE) return std::nullopt;
  return Denial{gateway_CAUSE_KIND, fmt::format("kind {}: unknown to this daemon", kind)};
}

Problem check(const layer2_SendRequest& request) {
  if (auto problem = check(request.content)) return problem;
  for (std::uint32_t i = 0; i < request.following._length; ++i) {
    if (auto problem = check(request.following._buffer[i], fmt::format("following[{}]", i))) return problem;
  }
  if (request.timeout > kMaximumTimeoutMs) {
    return Denial{gateway_CAUSE_FIELD,
                  fmt::format("timeout {} ms: out of range; allowed 0..{} ms, 0 = the daemon's default",
                              request.timeout, kMaximumTimeoutMs)};
  }
  return std::nullopt;
}

Problem check(const layer2_ObjectRequest& request) {
  const std::int64_t action = gateway::dds::raw_number_of(request.action);
  if (action == layer2_OBJECT_CONFIGURE) return check_settings(request);
  if (action < layer2_OBJECT_CONFIGURE || action > layer2_OBJECT_READ)
    return Denial{gateway_CAUSE_KIND, fmt::format("action {}: unknown to this daemon", action)};
  if (request.number >= MessageObjects::kMost) {
    return Denial{gateway_CAUSE_FIELD, fmt::format("number {}: no such object; allowed 0..{}", request.number,
                                                   MessageObjects::kMost - 1)};
  }
  if (action == layer2_OBJECT_READ && request.ask && !request.release)
    return Denial{gateway_CAUSE_FIELD, "ask: only with release, for the answer needs an open object"};
  if (action != layer2_OBJECT_SEND) return std::nullopt;
  if (request.content.remote) {
    return Denial{
        gateway_CAUSE_FIELD,
        "content.remote: an object sends data; to ask for some, read an object that receives with ask"};
  }
  if (request.every_time && !request.on_remote)
    return Denial{gateway_CAUSE_FIELD, "every_time: only with on_remote"};
  return check(request.content);
}

namespace {

/// Of an order to a message object.
Denial explain_object(Refusal refusal) {
  switch (refusal) {
    case Refusal::object_reserved:
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "number: this object belongs to the data mapping; take another one, 0..27 or 30..31"};
    case Refusal::object_direction:
      return Denial{
          gateway_CAUSE_WRONG_STATE,
          "number: this object is not configured for that; OBJECT_SEND and OBJECT_ABORT need one that "
          "sends, OBJECT_READ one that receives: configure it first"};
    case Refusal::object_pending:
      return Denial{
          gateway_CAUSE_QUEUE_FULL,
          "number: this object has a job, or asks for a frame; try again when that has ended, or abort it"};
    default:
      return Denial{gateway_CAUSE_FIELD,
                    "content: no data frame of the object's width (extended) with 0..8 bytes"};
  }
}

}  // namespace

Problem explain(Refusal refusal, std::uint16_t queue) {
  switch (refusal) {
    case Refusal::none:
      return std::nullopt;
    case Refusal::queue_full:
      return Denial{gateway_CAUSE_QUEUE_FULL,
                    fmt::format("queue full: at most {} may wait to be sent; try again when one has been",
                                text::counted(queue, "frame"))};
    case Refusal::too_late:
      return Denial{gateway_CAUSE_STALE,
                    "deadline: it had passed before the frame could be handed over; nothing was sent"};
    case Refusal::bad_frame:
      return Denial{gateway_CAUSE_FIELD,
                    "content: no frame that can be sent; allowed are data and remote frames with 0..8 bytes"};
    case Refusal::no_timer:
      return Denial{gateway_CAUSE_FIELD,
                    "number: that timer has nothing to send; set it first, or give it a [[timer]] section"};
    case Refusal::bus_full:
      return Denial{gateway_CAUSE_FIELD,
                    "period: with the other timers and the image more than the bus carries; make it longer"};
    case Refusal::no_image:
      return Denial{gateway_CAUSE_MAPPING, "there is no process image; give the daemon [[mapped]] sections"};
    case Refusal::queue_in_use:
      return Denial{gateway_CAUSE_QUEUE_FULL,
                    "data: more waits in a queue than it would have room for; try again, or empty it first "
                    "(can clear-queues)"};
    case Refusal::script_under_way:
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "data: a script that would be replaced is under way; try again when it has ended"};
    case Refusal::not_led:
      return Denial{gateway_CAUSE_WRONG_STATE,
                    "run and stop follow a program (module.run_follows), which is not there or says stop; "
                    "start it, or let it say run"};
    case Refusal::image_owned:
      return Denial{
          gateway_CAUSE_WRONG_STATE,
          "the image belongs to a writer of ImageOutputs, another mapping was taken over, or the daemon was "
          "made read-only; look at `cansync can image`, then write again"};
    case Refusal::not_permitted:
      return Denial{gateway_CAUSE_RIGHT,
                    "the daemon may not reset the controller; give it the right CAP_NET_ADMIN"};
    case Refusal::no_controller:
      return Denial{
          gateway_CAUSE_BUS_UNAVAILABLE,
          "the controller cannot be reset: its interface is missing or down, or its driver does not do it; "
          "set the interface up, or anew"};
    case Refusal::reset_under_way:
      return Denial{gateway_CAUSE_QUEUE_FULL, "the controller is being reset; try again when that has ended"};
    case Refusal::object_reserved:
    case Refusal::object_direction:
    case Refusal::object_pending:
    case Refusal::object_frame:
      return explain_object(refusal);
    case Refusal::not_running:
      return Denial{gateway_CAUSE_WRONG_STATE, "in stop nothing is sent; let it run first (cansync can run)"};
    case Refusal::stopped:
      break;
  }
  return Denial{gateway_CAUSE_STOPPING, "the daemon is being stopped; send again when it runs"};
}

}  // namespace layer2::dds
