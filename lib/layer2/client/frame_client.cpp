#include "layer2/client/frame_client.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "layer2/dds/convert.h"

namespace layer2::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kSettle{100};  ///< in which more of what was told before may come

}  // namespace

FrameClient::FrameClient(const Options& options)
    : RequestClient(options),
      replies_(participant(), reply_partitions(), &signal()),
      control_replies_(participant(), reply_partitions(), &signal()),
      object_replies_(participant(), reply_partitions(), &signal()),
      batches_(participant(), &signal()),
      status_(participant(), &signal()),
      timer_status_(participant(), &signal()),
      object_status_(participant(), &signal()),
      image_reader_(participant(), &signal()),
      requests_(participant(), 0, &signal()),
      controls_(participant(), 0, &signal()),
      object_requests_(participant(), 0, &signal()),
      cancels_(participant(), 0, &signal()) {
  connect(
      "layer2", &replies_,
      {.requests = {&requests_, &controls_, &cancels_}, .replies = {&replies_, &control_replies_}},
      [this] { return batches_.matched() != 0 && status_.matched() != 0; },
      [this] { return status_.matched() != 0; });
}

milliseconds FrameClient::monitoring_of(std::uint32_t timeout_ms) const {
  if (timeout_ms != 0) return milliseconds(timeout_ms);
  return newest_status() ? milliseconds(newest_status()->send_timeout) : kDefaultMonitoring;
}

Begun FrameClient::begin_send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice) {
  return begin_send(std::span(&frame, 1), timeout_ms, choice);
}

Begun FrameClient::begin_send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                              const SendChoice& choice) {
  layer2_SendRequest request = {};
  if (frames.empty() || frames.size() > layer2_BATCH) {
    return {0, gateway::dds::refused(
                   gateway_CAUSE_LENGTH,
                   fmt::format("frames of one request: {}; allowed: 1..{}", frames.size(), layer2_BATCH))};
  }
  std::vector<layer2_CanFrame> all;
  for (const can::Frame& frame : frames) all.push_back(dds::to_idl(frame));
  request.content = all.front();
  request.following._buffer = all.data() + 1;
  request.following._length = request.following._maximum = static_cast<std::uint32_t>(all.size() - 1);
  request.deadline = choice.deadline;
  request.timeout = timeout_ms;
  request.high_priority = choice.high_priority;
  request.by_identifier = choice.by_identifier;
  return begin(requests_, request, "operator");
}

Begun FrameClient::begin_control(const layer2_ControlRequest& wanted) {
  layer2_ControlRequest request = wanted;
  return begin(controls_, request, "engineer");
}

Begun FrameClient::begin_object(const layer2_ObjectRequest& wanted) {
  if (auto problem = obstacle()) return {0, std::move(problem)};
  if (!objects_reached())
    return {0, gateway::dds::refused(
                   gateway_CAUSE_WRONG_STATE,
                   "no daemon reads requests to message objects yet; try again, or update the daemon")};
  layer2_ObjectRequest request = wanted;
  return begin(object_requests_, request, "engineer");
}

bool FrameClient::objects_reached() const {
  return !object_requests_.permitted() ||
         (sight().is_read(object_requests_) && sight().is_written(object_replies_));
}

void FrameClient::wait_for_objects() {
  (void)look_until(kDefaultMonitoring, [&] { return objects_reached(); });
}

SendResult FrameClient::send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice) {
  return send(std::span(&frame, 1), timeout_ms, choice);
}

SendResult FrameClient::send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                             const SendChoice& choice) {
  look_until_reached();
  return await(begin_send(frames, timeout_ms, choice), monitoring_of(timeout_ms));
}

SendResult FrameClient::control(const layer2_ControlRequest& wanted) {
  look_until_reached();
  return await(begin_control(wanted), kDefaultMonitoring);
}

SendResult FrameClient::await(const Begun& begun, milliseconds monitoring) {
  return RequestClient::await<SendResult>(begun, monitoring + kGrace, cancels_,
                                          [this](const auto& ended) { take_replies(ended); });
}

void FrameClient::take_replies(const std::function<void(std::uint64_t, const SendResult&)>& ended) {
  replies_.take([&](const layer2_SendReply& reply) {
    hand_on(reply, SendResult{.sent_time = reply.sent_time, .sent = reply.sent}, ended);
  });
  control_replies_.take([&](const layer2_ControlReply& reply) { hand_on(reply, SendResult(), ended); });
  object_replies_.take([&](const layer2_ObjectReply& reply) {
    hand_on(reply,
            SendResult{.sent_time = reply.time,
                       .job_number = reply.job_number,
                       .fresh = reply.fresh,
                       .overrun = reply.overrun,
                       .content = dds::to_core(reply.content)},
            ended);
  });
}

void FrameClient::look(const Listener& listener) {
  sight().look();
  take_replies([&](std::uint64_t number, const SendResult& result) {
    if (listener.ended) listener.ended(number, result);
  });
  batches_.take([&](const layer2_FrameBatch& batch) {
    if (listener.batch) listener.batch(batch);
  });
  (void)take_status();
  if (listener.object) object_status_.take(listener.object);
  if (listener.image) image_reader_.take(listener.image);
}

template <class Came>
bool FrameClient::look_until(milliseconds time, Came&& came) {
  return wait_until(time, [&] {
    sight().look();
    take_replies([](std::uint64_t, const SendResult&) {});  // of requests that were given up
    return came();
  });
}

template <class Status>
void FrameClient::keep_newest(gateway::dds::Reader<Status>& reader, std::map<unsigned, Status>& newest,
                              milliseconds time) {
  // Those of before come one by one, and nothing tells which is the last.
  auto settled = newest.empty() ? steady_clock::time_point::max() : steady_clock::now();
  (void)look_until(time, [&] {
    reader.take(
        [&](const Status& sample) {
          newest[sample.number] = sample;
          settled = steady_clock::now() + kSettle;
        },
        [&](const Status& gone) { newest.erase(gone.number); });
    return steady_clock::now() >= settled;
  });
}

std::vector<layer2_TimerStatus> FrameClient::timers(milliseconds time) {
  keep_newest(timer_status_, timers_, time);
  std::vector<layer2_TimerStatus> found;
  for (const auto& [number, timer] : timers_) found.push_back(timer);
  return found;
}

void FrameClient::wait_for_match(const gateway::dds::WriterBase& writer) {
  if (writer.permitted() && writer.matched() == 0)
    (void)look_until(kDefaultMonitoring, [&] { return writer.matched() != 0; });
}

std::optional<layer2_ProcessImage> FrameClient::image(milliseconds time, bool fresh) {
  if (fresh) image_.reset();
  (void)look_until(time, [&] {
    image_reader_.take([this](const layer2_ProcessImage& sample) { image_ = sample; },
                       [this](const layer2_ProcessImage& /*gone*/) { image_.reset(); });
    return image_.has_value();
  });
  return image_;
}

SendResult FrameClient::configure(std::string_view toml) {
  layer2_ControlRequest request = {};
  request.kind = layer2_CONTROL_CONFIGURE;
  std::vector<std::uint8_t> bytes(toml.begin(), toml.end());
  request.data._buffer = bytes.data();
  request.data._length = request.data._maximum = static_cast<std::uint32_t>(bytes.size());
  return control(request);
}

SendResult FrameClient::object(const layer2_ObjectRequest& wanted) {
  wait_for_objects();
  look_until_reached();
  return await(begin_object(wanted), kDefaultMonitoring);
}

std::vector<layer2_ObjectStatus> FrameClient::objects(milliseconds time) {
  keep_newest(object_status_, objects_, time);
  std::vector<layer2_ObjectStatus> found;
  for (const auto& [number, object] : objects_) {
    if (object.configured) found.push_back(object);
  }
  return found;
}

bool FrameClient::events(milliseconds time, const std::function<void(const layer2_ModuleEvent&)>& on_event) {
  if (!events_)
    events_ = std::make_unique<gateway::dds::Reader<layer2_ModuleEvent>>(participant(), &signal());
  return look_until(time, [&] { return events_->take(on_event) > 0; });
}

bool FrameClient::receive(milliseconds time, const std::function<void(const layer2_FrameBatch&)>& on_batch) {
  return look_until(time, [&] { return batches_.take(on_batch) > 0; });
}

const std::optional<layer2_FrameStatus>& FrameClient::take_status() {
  return newest_.take(status_);
}

std::optional<layer2_FrameStatus> FrameClient::status(milliseconds time) {
  (void)look_until(time, [this] { return take_status().has_value(); });
  return newest_status();
}

}  // namespace layer2::client
