#include "layer2/dds/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <iterator>

#include "dds/bounded_text.h"
#include "text/counts.h"

namespace layer2::dds {
namespace {

template <class Reply>
Reply reply_to(const RequestKey& key) noexcept {
  Reply reply = {};
  std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
  reply.request = key.request;
  return reply;
}

Control control_of(layer2_ControlKind kind) noexcept {
  switch (kind) {
    case layer2_CONTROL_RUN:
      return Control::run;
    case layer2_CONTROL_STOP:
      return Control::stop;
    case layer2_CONTROL_START_TIMER:
      return Control::start_timer;
    case layer2_CONTROL_STOP_TIMER:
      return Control::stop_timer;
    case layer2_CONTROL_SET_TIMER:
      return Control::set_timer;
    case layer2_CONTROL_RESET_CONTROLLER:
      return Control::reset_controller;
    case layer2_CONTROL_CLEAR_QUEUES:
      return Control::clear_queues;
    case layer2_CONTROL_RESET_OVERFLOW:
      return Control::reset_overflow;
    case layer2_CONTROL_CONFIGURE:
      return Control::configure;
    default:
      return Control::write_image;
  }
}

layer2_ObjectJob job_of(JobPlace place) noexcept {
  switch (place) {
    case JobPlace::none:
      return layer2_OBJECT_JOB_NONE;
    case JobPlace::waits_for_remote:
      return layer2_OBJECT_JOB_HELD;
    case JobPlace::ready:
      return layer2_OBJECT_JOB_READY;
    case JobPlace::in_controller:
      break;
  }
  return layer2_OBJECT_JOB_IN_CONTROLLER;
}

layer2_ObjectJobEnd end_of(JobState state) noexcept {
  switch (state) {
    case JobState::done:
      return layer2_OBJECT_END_DONE;
    case JobState::aborted:
      return layer2_OBJECT_END_ABORTED;
    case JobState::timed_out:
      return layer2_OBJECT_END_TIMED_OUT;
    case JobState::none:
    case JobState::under_way:
      break;
  }
  return layer2_OBJECT_END_NONE;
}

}  // namespace

can::Frame to_core(const layer2_CanFrame& frame) noexcept {
  can::Frame out;
  out.extended = frame.extended;
  out.remote = frame.remote;
  out.id = frame.identifier & (out.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask);
  out.dlc = std::min<std::uint8_t>(frame.length, 8);
  if (!out.remote) std::copy_n(std::begin(frame.data), out.dlc, out.data.begin());
  return out;
}

SendOrder to_core(const layer2_SendRequest& request, OrderId id, Time default_timeout,
                  std::span<const can::Frame> following) noexcept {
  Time timeout = std::chrono::milliseconds(request.timeout);
  if (timeout == Time{0}) timeout = default_timeout;
  return {id,
          to_core(request.content),
          timeout,
          request.high_priority ? Priority::high : Priority::normal,
          request.by_identifier ? Placing::by_identifier : Placing::last,
          following};
}

std::vector<can::Frame> following_of(const layer2_SendRequest& request) {
  std::vector<can::Frame> frames;
  for (std::uint32_t i = 0; i < request.following._length; ++i)
    frames.push_back(to_core(request.following._buffer[i]));
  return frames;
}

ControlOrder to_core(const layer2_ControlRequest& request, OrderId id) noexcept {
  ControlOrder order;
  order.id = id;
  order.what = control_of(request.kind);
  order.number = request.number;
  order.timer.frame = to_core(request.content);
  order.timer.period = std::chrono::microseconds(request.period);
  order.timer.phase = std::chrono::microseconds(request.phase);
  order.timer.cyclic = request.cyclic;
  order.address = request.address;
  order.size = std::min<std::uint8_t>(request.size, ControlOrder::kMostBytes);
  std::copy_n(std::begin(request.bytes), order.size, order.bytes.begin());
  return order;
}

ObjectOrder to_core(const layer2_ObjectRequest& request, OrderId id,
                    std::span<const ObjectEntry> settings) noexcept {
  static constexpr std::array kKinds = {ObjectOrder::Kind::configure, ObjectOrder::Kind::send,
                                        ObjectOrder::Kind::abort, ObjectOrder::Kind::read};
  ObjectOrder order;
  order.id = id;
  order.kind = kKinds[std::min<std::size_t>(static_cast<std::size_t>(request.action), kKinds.size() - 1)];
  order.number = request.number;
  order.job = {to_core(request.content), request.on_remote, request.every_time};
  order.release = request.release;
  order.ask = request.ask;
  order.anew = request.anew;
  order.settings = settings;
  return order;
}

std::vector<ObjectEntry> entries_of(const layer2_ObjectRequest& request) {
  std::vector<ObjectEntry> entries;
  for (std::uint32_t i = 0; i < request.settings._length; ++i) {
    const layer2_ObjectSettings& settings = request.settings._buffer[i];
    const MaskRule rule{settings.identifier, settings.mask, settings.extended};
    entries.push_back(
        {settings.number,
         {rule, settings.transmit, std::chrono::milliseconds(settings.timeout), settings.tell}});
  }
  return entries;
}

layer2_CanFrame to_idl(const can::Frame& frame) noexcept {
  layer2_CanFrame out = {};
  out.identifier = frame.identifier();
  out.extended = frame.extended;
  out.remote = frame.remote;
  out.length = std::min<std::uint8_t>(frame.dlc, 8);
  if (!frame.remote) std::copy_n(frame.data.begin(), out.length, std::begin(out.data));
  return out;
}

layer2_ReceivedFrame received_frame(const can::Frame& frame, std::int64_t receive_time, std::uint8_t range,
                                    bool high_priority) noexcept {
  layer2_ReceivedFrame out = {};
  out.received = to_idl(frame);
  out.receive_time = receive_time;
  out.range_index = range;
  out.high_priority = high_priority;
  return out;
}

gateway_ReplyCode to_reply_code(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::done:
      return gateway_REPLY_DONE;
    case Outcome::no_answer:
      return gateway_REPLY_NO_ANSWER;
    case Outcome::timeout:
      return gateway_REPLY_TIMEOUT;
    case Outcome::cancelled:
    case Outcome::deleted:
      return gateway_REPLY_CANCELLED;
    case Outcome::displaced:
      return gateway_REPLY_REPLACED;
    case Outcome::stopped:
      break;
  }
  return gateway_REPLY_MASTER_STOPPED;
}

std::string_view reason_of(Outcome outcome, Obstacle obstacle) noexcept {
  switch (outcome) {
    case Outcome::done:
      return "";
    case Outcome::no_answer:
      return "handed over, but not seen on the bus within the monitoring time: it may have been sent, or be "
             "sent yet; check that another node is on the bus";
    case Outcome::timeout:
      return can::reason_not_sent(obstacle);
    case Outcome::cancelled:
      return "cancelled";
    case Outcome::displaced:
      return "not sent: deleted for a newer frame, because the queue was full; send less at a time, or give the "
             "queue more room";
    case Outcome::deleted:
      return "not sent: the queues were emptied";
    case Outcome::stopped:
      break;
  }
  return "the daemon was stopped before the frame was sent";
}

layer2_SendReply send_reply(const RequestKey& key, const Answer& answer, std::int64_t sent_time,
                            std::size_t frames) {
  auto reply = reply_to<layer2_SendReply>(key);
  reply.code = to_reply_code(answer.outcome);
  const std::string_view reason = reason_of(answer.outcome, answer.obstacle);
  if (frames == 1 || reason.empty()) {
    copy_text(reason, reply.reason);
  } else {
    copy_text(
        fmt::format("on the bus: {}; the next: {}", text::counted_of(answer.seen, frames, "frame"), reason),
        reply.reason);
  }
  reply.sent = answer.seen;
  if (answer.outcome == Outcome::done) reply.sent_time = sent_time;
  return reply;
}

layer2_SendReply send_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept {
  auto reply = reply_to<layer2_SendReply>(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

layer2_ObjectReply object_reply(const RequestKey& key, const ObjectAnswer& answer,
                                std::int64_t time) noexcept {
  auto reply = reply_to<layer2_ObjectReply>(key);
  reply.code = to_reply_code(answer.outcome);
  copy_text(reason_of(answer.outcome, answer.obstacle), reply.reason);
  if (answer.outcome == Outcome::done) reply.time = time;
  reply.job_number = answer.job_number;
  reply.fresh = answer.fresh;
  if (answer.fresh) {
    reply.overrun = answer.reading.overrun;
    reply.content = to_idl(answer.reading.frame);
  }
  return reply;
}

layer2_ObjectReply object_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept {
  auto reply = reply_to<layer2_ObjectReply>(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

layer2_ObjectStatus object_status(unsigned number, const ObjectState& state, std::int64_t time) noexcept {
  layer2_ObjectStatus out = {};
  out.number = static_cast<std::uint8_t>(number);
  out.configured = state.configured;
  out.transmit = state.settings.transmit;
  out.extended = state.settings.rule.extended;
  out.identifier = state.settings.rule.identifier;
  if (!out.transmit) out.mask = state.settings.rule.mask;
  out.timeout = static_cast<std::uint32_t>(
      std::chrono::duration_cast<std::chrono::milliseconds>(state.settings.timeout).count());
  out.tell = state.settings.tell;
  if (out.transmit) {
    out.job = job_of(state.place);
    out.every_time = state.every_time;
    out.ended_as = end_of(state.ended_as);
  }
  out.open = state.open;
  out.full = state.full;
  out.overrun = state.overrun;
  out.content = to_idl(state.frame);
  out.time = time;
  out.sent = state.sent;
  out.received = state.received;
  out.overruns = state.overruns;
  out.job_number = state.job_number;
  out.job_sent = state.job_sent;
  return out;
}

layer2_ModuleEvent module_event(const ModuleEvent& event, std::int64_t time) noexcept {
  layer2_ModuleEvent out = {};
  out.time = time;
  const bool of_object = event.kind != ModuleEvent::Kind::send_queue_empty;
  out.object_number = of_object ? event.number : 0xFF;
  out.kind = event.kind == ModuleEvent::Kind::object_received
                 ? layer2_OBJECT_RECEIVED
                 : (of_object ? layer2_OBJECT_SENT : layer2_SEND_QUEUE_EMPTY);
  if (of_object) out.content = to_idl(event.frame);
  return out;
}

layer2_ControlReply control_reply(const RequestKey& key, Outcome outcome) noexcept {
  auto reply = reply_to<layer2_ControlReply>(key);
  reply.code = to_reply_code(outcome);
  const bool stopped = outcome == Outcome::stopped;
  copy_text(stopped ? "the daemon was stopped before it was done" : reason_of(outcome, Obstacle::none),
            reply.reason);
  return reply;
}

layer2_ControlReply control_refused(const RequestKey& key, const gateway::dds::Denial& denial) noexcept {
  auto reply = reply_to<layer2_ControlReply>(key);
  gateway::dds::refuse(reply, denial);
  return reply;
}

}  // namespace layer2::dds
