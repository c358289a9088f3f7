#include "daemon/layer2/gateway/send_requests.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <variant>

#include "can/candump.h"
#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"
#include "dds/enumerator.h"
#include "text/counts.h"

namespace cansyncd {

template class JobDesk<SendRequests>;

std::string frame_text(const can::Frame& frame) {
  std::array<char, can::kCandumpLineLimit> line;
  const std::size_t size = can::write_candump_line({}, "x", frame, line);
  const std::string text(line.data(), size == 0 ? 0 : size - 1);  // without its line feed
  return text.substr(text.rfind(' ') + 1);
}

std::optional<Change> SendRequests::change_of(const layer2_SendRequest& sample, const SendContext&) {
  Change change;
  change.action = "send_frame";
  const std::string more =
      sample.following._length == 0 ? "" : fmt::format(" and {} more", sample.following._length);
  change.new_value = check(sample) ? fmt::format("identifier 0x{:X}, {}", sample.content.identifier,
                                                 text::counted(sample.content.length, "byte"))
                                   : frame_text(layer2::dds::to_core(sample.content)) + more;
  change.series = fmt::format("0x{:X}{}", sample.content.identifier, sample.content.extended ? "x" : "");
  return change;
}

std::optional<Change> SendRequests::change_of(const layer2_ControlRequest& sample, const SendContext&) {
  static constexpr std::array<const char*, layer2_CONTROL_CONFIGURE + 1> kActions = {
      "run",          "stop",           "start_timer", "stop_timer", "set_timer", "reset_controller",
      "clear_queues", "reset_overflow", "write_image", "configure"};
  Change change;
  const auto kind = static_cast<std::size_t>(sample.kind);
  change.action = kind < kActions.size() ? kActions[kind] : "control";
  if (sample.kind == layer2_CONTROL_START_TIMER || sample.kind == layer2_CONTROL_STOP_TIMER)
    change.new_value = fmt::format("timer {}", sample.number);
  if (sample.kind == layer2_CONTROL_SET_TIMER) {
    change.new_value = fmt::format("timer {}: {} every {} us from {} us on{}", sample.number,
                                   frame_text(layer2::dds::to_core(sample.content)), sample.period,
                                   sample.phase, sample.cyclic ? "" : ", once");
  }
  if (sample.kind == layer2_CONTROL_CONFIGURE)
    change.new_value = text::counted(sample.data._length, "byte") + " of configuration";
  if (sample.kind == layer2_CONTROL_WRITE_IMAGE) {
    change.new_value = fmt::format("{} from byte {} on", text::counted(sample.size, "byte"), sample.address);
    change.series = change.action;
  }
  return change;
}

std::optional<Change> SendRequests::change_of(const layer2_ObjectRequest& sample, const SendContext&) {
  Change change;
  const std::string object = fmt::format("object {}", sample.number);
  switch (gateway::dds::raw_number_of(sample.action)) {
    case layer2_OBJECT_CONFIGURE:
      change.action = "configure_objects";
      change.new_value =
          text::counted(sample.settings._length, "object") + (sample.anew ? ", and no other" : "");
      break;
    case layer2_OBJECT_SEND:
      change.action = "object_send";
      change.new_value = object;
      change.series = object;
      if (!check(sample)) change.new_value += " " + frame_text(layer2::dds::to_core(sample.content));
      if (sample.on_remote)
        change.new_value += sample.every_time ? ", for remote frames" : ", for a remote frame";
      break;
    case layer2_OBJECT_ABORT:
      change.action = "object_abort";
      change.new_value = object;
      break;
    case layer2_OBJECT_READ:
      if (!sample.ask) return std::nullopt;  // nothing is sent
      change.action = "object_ask";
      change.new_value = object;
      change.series = object;
      break;
    default:
      change.action = "object";
      break;
  }
  return change;
}

std::optional<FrameRequest> SendRequests::request_of(const layer2_SendRequest& sample, JobId id,
                                                     std::vector<std::uint8_t>& /*data*/) const {
  const auto following = std::make_shared<const std::vector<can::Frame>>(layer2::dds::following_of(sample));
  return FrameRequest{layer2::dds::to_core(sample, id, running_.config().send.timeout, *following), following,
                      sample.deadline};
}

std::optional<FrameRequest> SendRequests::request_of(const layer2_ControlRequest& sample, JobId id,
                                                     std::vector<std::uint8_t>& /*data*/) const {
  layer2::ControlOrder order = layer2::dds::to_core(sample, id);
  FrameRequest request;
  if (order.what == layer2::Control::configure) {
    const std::string_view text(reinterpret_cast<const char*>(sample.data._buffer), sample.data._length);
    std::string problem;
    if (running_.under_way()) {
      request.problem = gateway::dds::Denial{gateway_CAUSE_QUEUE_FULL,
                                             "another configuration is being taken over; try again"};
    } else if ((request.prepared = running_.prepare(text, problem)) == nullptr) {
      request.problem = gateway::dds::Denial{gateway_CAUSE_FIELD, std::move(problem)};
    } else {
      order.prepared = &request.prepared->module;
    }
  }
  request.job = order;
  return request;
}

void SendRequests::learn(const FrameRequest& request, const SendDone& done) {
  if (request.prepared && done.refusal == layer2::Refusal::none &&
      done.answer.outcome == layer2::Outcome::done)
    running_.adopt(*request.prepared);
}

gateway::dds::Problem SendRequests::objection(const FrameRequest& request, const SendContext& context) {
  using gateway::dds::Denial;
  if (request.problem) return request.problem;
  const auto* order = std::get_if<layer2::ControlOrder>(&request.job);
  if (order == nullptr) return std::nullopt;
  if (order->what == layer2::Control::write_image && !context.image.owner().empty())
    return Denial{
        gateway_CAUSE_WRONG_STATE,
        fmt::format("the image belongs to {}, a writer of ImageOutputs; write when that has given it up",
                    context.image.owner())};
  if (order->what == layer2::Control::run && context.lead.follows() && !context.lead.wants_run())
    return layer2::dds::explain(layer2::Refusal::not_led, 0);
  return std::nullopt;
}

std::optional<FrameRequest> SendRequests::request_of(const layer2_ObjectRequest& sample, JobId id,
                                                     std::vector<std::uint8_t>& /*data*/) {
  const auto entries =
      std::make_shared<const std::vector<layer2::ObjectEntry>>(layer2::dds::entries_of(sample));
  return FrameRequest{layer2::dds::to_core(sample, id, *entries), entries, 0};
}

LaneLimits SendRequests::lane_limits() const {
  // A queue that refuses is never asked for more than it has room for.
  constexpr unsigned kRoom = layer2::Station::kMostQueue;
  const SendConfig& send = running_.config().send;
  const bool deletes = send.overflow == layer2::Overflow::delete_oldest;
  const unsigned normal = deletes ? kRoom : send.queue;
  const unsigned high = deletes ? kRoom : send.high_queue;
  // An object that has a job refuses another, so none waits here.
  return {{normal, normal, kFramesOfClient}, {high, high, kFramesOfClient}, {16, 16}, {kRoom, kRoom}};
}

std::optional<QueuesEmptied> SendRequests::newer_of(const Request& request,
                                                    const SendContext& /*context*/) noexcept {
  const auto* order = std::get_if<layer2::ControlOrder>(&request.job);
  if (order == nullptr) return std::nullopt;
  if (order->what != layer2::Control::stop && order->what != layer2::Control::clear_queues)
    return std::nullopt;
  return QueuesEmptied{};
}

unsigned SendRequests::weight_of(const Request& request) noexcept {
  const auto* order = std::get_if<layer2::SendOrder>(&request.job);
  return order == nullptr ? 1 : static_cast<unsigned>(order->following.size()) + 1;
}

Lane SendRequests::lane_of(const Request& request) noexcept {
  const auto* object = std::get_if<layer2::ObjectOrder>(&request.job);
  if (object != nullptr && object->kind == layer2::ObjectOrder::Kind::send)
    return {FrameLane::object, object->number};
  const auto* order = std::get_if<layer2::SendOrder>(&request.job);
  if (order == nullptr) return {FrameLane::control, 0};
  return {order->priority == layer2::Priority::high ? FrameLane::high : FrameLane::normal, 0};
}

bool SendRequests::hand_on(const Request& request, const SendContext& context) {
  const auto* control = std::get_if<layer2::ControlOrder>(&request.job);
  if (control != nullptr && context.lead.follows() &&
      (control->what == layer2::Control::run || control->what == layer2::Control::stop)) {
    if (!context.lead.settled()) return false;  // what the program said before goes first
    layer2::ControlOrder order = *control;
    order.led = context.lead.wants_run();
    return context.exchange.requests.try_push(order);
  }
  if (control != nullptr && control->what == layer2::Control::write_image) {
    if (context.exchange.requests.room() == 0) return false;  // the image and its order go together
    layer2::ControlOrder order = *control;
    order.written = context.image.write(order.address, std::span(order.bytes).first(order.size));
    return context.exchange.requests.try_push(order);
  }
  const auto* frame = std::get_if<layer2::SendOrder>(&request.job);
  if (frame != nullptr && request.deadline != 0) {
    layer2::SendOrder order = *frame;
    const std::int64_t now = wall_clock_now();
    order.timeout = std::min(order.timeout, layer2::Time(std::max(request.deadline, now) - now));
    return context.exchange.requests.try_push(order);
  }
  return std::visit([&](const auto& order) { return context.exchange.requests.try_push(order); },
                    request.job);
}

gateway::dds::Problem SendRequests::refusal(const SendDone& done, const Request& request) const {
  const SendConfig& send = running_.config().send;
  const auto* frame = std::get_if<layer2::SendOrder>(&request.job);
  const bool high = frame != nullptr && frame->priority == layer2::Priority::high;
  auto problem = layer2::dds::explain(done.refusal, high ? send.high_queue : send.queue);
  const auto* object = std::get_if<layer2::ObjectOrder>(&request.job);
  if (problem && object != nullptr && object->kind == layer2::ObjectOrder::Kind::configure)
    problem->reason = fmt::format("settings[{}].{}", done.object.place, problem->reason);
  return problem;
}

std::string_view SendRequests::name(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::no_answer:
      return "no_answer";
    case Outcome::timeout:
      return "timeout";
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::displaced:
      return "displaced";
    case Outcome::deleted:
      return "deleted";
    case Outcome::stopped:
      break;
  }
  return "stopped";
}

}  // namespace cansyncd
