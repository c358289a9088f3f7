#include "layer2/client/frame_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "dds/bounded_text.h"
#include "dds/daemon_identity.h"
#include "dds/reply_partition.h"
#include "dds/security.h"
#include "layer2/dds/convert.h"

namespace layer2::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// Waiting is looked at again so often: `stop` is seen soon.
constexpr milliseconds kLook{20};
constexpr milliseconds kSettle{100};  ///< in which more of what was told before may come
/// From the end of a request's monitoring time to its reply, and from a cancel to it.
constexpr milliseconds kGrace{5000};
/// For the monitoring time of a daemon that has not told its own.
constexpr milliseconds kDefaultMonitoring{1000};

/// Replies that come after their request was given up must be taken too, for a full reader holds up all
/// topics.
constexpr std::uint64_t kNobodysRequest = 0;

/// Who may write a topic of requests, with DDS Security on.
template <class Request>
constexpr std::string_view role_of = "engineer";
template <>
constexpr std::string_view role_of<layer2_SendRequest> = "operator";

}  // namespace

FrameClient::FrameClient(const Options& options)
    : options_(options),
      identity_(gateway::dds::random_client_identity()),
      participant_(options.participant()),
      replies_(participant_, gateway::dds::Partitions{gateway::dds::reply_partition(options.bus, identity_)},
               &signal_),
      control_replies_(participant_,
                       gateway::dds::Partitions{gateway::dds::reply_partition(options.bus, identity_)},
                       &signal_),
      object_replies_(participant_,
                      gateway::dds::Partitions{gateway::dds::reply_partition(options.bus, identity_)},
                      &signal_),
      batches_(participant_, &signal_),
      status_(participant_, &signal_),
      timer_status_(participant_, &signal_),
      object_status_(participant_, &signal_),
      image_reader_(participant_, &signal_),
      bus_reader_(participant_, &signal_),
      sight_(participant_, signal_, options.bus),
      requests_(participant_, 0, &signal_),
      controls_(participant_, 0, &signal_),
      object_requests_(participant_, 0, &signal_),
      cancels_(participant_, 0, &signal_) {
  sight_.find(
      options, signal_, "layer2",
      {.requests = {&requests_, &controls_, &cancels_}, .replies = {&replies_, &control_replies_}},
      [this] { return batches_.matched() != 0 && status_.matched() != 0; },
      [this] { return status_.matched() != 0; });
}

std::optional<SendResult> FrameClient::obstacle() {
  auto found = sight_.obstacle();
  if (!found) return std::nullopt;
  if (found->gone) return SendResult{.reason = std::move(found->reason)};
  return SendResult{true, gateway_REPLY_REFUSED, gateway_CAUSE_OTHER_DAEMON, std::move(found->reason)};
}

milliseconds FrameClient::monitoring_of(std::uint32_t timeout_ms) const {
  if (timeout_ms != 0) return milliseconds(timeout_ms);
  return newest_ ? milliseconds(newest_->send_timeout) : kDefaultMonitoring;
}

Begun FrameClient::begin_send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice) {
  return begin_send(std::span(&frame, 1), timeout_ms, choice);
}

Begun FrameClient::begin_send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                              const SendChoice& choice) {
  layer2_SendRequest request = {};
  if (frames.empty() || frames.size() > layer2_BATCH) {
    return {
        0, SendResult{true, gateway_REPLY_REFUSED, gateway_CAUSE_LENGTH,
                      fmt::format("frames of one request: {}; allowed: 1..{}", frames.size(), layer2_BATCH)}};
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
  return begin(requests_, request);
}

Begun FrameClient::begin_control(const layer2_ControlRequest& wanted) {
  return begin(controls_, wanted);
}

Begun FrameClient::begin_object(const layer2_ObjectRequest& wanted) {
  if (auto problem = obstacle()) return {0, *std::move(problem)};
  if (objects_reached()) return begin(object_requests_, wanted);
  return {0, SendResult{true, gateway_REPLY_REFUSED, gateway_CAUSE_WRONG_STATE,
                        "no daemon reads requests to message objects yet; try again, or update the daemon"}};
}

bool FrameClient::objects_reached() const {
  return !object_requests_.permitted() ||
         (sight_.is_read(object_requests_) && sight_.is_written(object_replies_));
}

void FrameClient::wait_for_objects() {
  wait_until(kDefaultMonitoring, [&] { return objects_reached(); });
}

SendResult FrameClient::send(const can::Frame& frame, std::uint32_t timeout_ms, const SendChoice& choice) {
  return send(std::span(&frame, 1), timeout_ms, choice);
}

SendResult FrameClient::send(std::span<const can::Frame> frames, std::uint32_t timeout_ms,
                             const SendChoice& choice) {
  sight_.look_until_reached(options_, signal_);
  return await(begin_send(frames, timeout_ms, choice), monitoring_of(timeout_ms));
}

SendResult FrameClient::control(const layer2_ControlRequest& wanted) {
  sight_.look_until_reached(options_, signal_);
  return await(begin_control(wanted), kDefaultMonitoring);
}

template <class Request>
Begun FrameClient::begin(gateway::dds::Writer<Request>& writer, Request request) {
  if (auto problem = obstacle()) return {0, *std::move(problem)};
  std::copy(identity_.begin(), identity_.end(), std::begin(request.client));
  request.request = ++number_;
  gateway::dds::copy_text(options_.client_name, request.client_name);
  gateway::dds::set_daemon(sight_.choice().daemon(), request);
  if (const auto code = writer.write(request); code != DDS_RETCODE_OK) {
    const bool forbidden = code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
    const bool full = code == DDS_RETCODE_TIMEOUT;
    return {0,
            SendResult{
                true, gateway_REPLY_REFUSED,
                forbidden ? gateway_CAUSE_RIGHT : (full ? gateway_CAUSE_SHARED_LIMIT : gateway_CAUSE_UNKNOWN),
                forbidden ? gateway::dds::no_right(gateway::dds::topic_info<Request>.name, role_of<Request>)
                          : fmt::format("the request could not be written: {}", dds_strretcode(code))}};
  }
  return {request.request, std::nullopt};
}

bool FrameClient::may_answer(const gateway::dds::DaemonIdentity& daemon) {
  if (sight_.choice().may_answer(daemon)) return true;
  sight_.choice().program_told();
  return false;
}

SendResult FrameClient::await(const Begun& begun, milliseconds monitoring) {
  if (begun.not_begun) return *begun.not_begun;
  const auto daemon = sight_.choice().daemon();
  auto end = steady_clock::now() + monitoring + kGrace;
  bool cancelled = false;
  while (!cancelled || steady_clock::now() < end) {
    if (auto result = take_reply(begun.request)) return *result;
    if (!may_answer(daemon)) return {.reason = "the daemon has gone"};
    if (!cancelled && (options_.stopped() || steady_clock::now() >= end)) {
      cancelled = true;
      cancel(begun.request, daemon);
      end = steady_clock::now() + kGrace;
    }
    (void)signal_.wait(static_cast<int>(kLook.count()));
    signal_.clear();
  }
  return {.reason = "the daemon did not answer"};
}

std::optional<SendResult> FrameClient::take_reply(std::uint64_t request) {
  sight_.look();
  std::optional<SendResult> found;
  take_replies([&](std::uint64_t number, const SendResult& result) {
    if (number == request) found = result;
  });
  return found;
}

void FrameClient::take_replies(const std::function<void(std::uint64_t, const SendResult&)>& ended) {
  const auto tell = [&](const auto& reply, SendResult result) {
    if (!std::equal(identity_.begin(), identity_.end(), reply.client)) return;
    result.replied = true;
    result.code = reply.code;
    result.cause = reply.cause;
    result.reason = std::string(gateway::dds::text(reply.reason));
    ended(reply.request, result);
  };
  replies_.take([&](const layer2_SendReply& reply) {
    tell(reply, {.sent_time = reply.sent_time, .sent = reply.sent});
  });
  control_replies_.take([&](const layer2_ControlReply& reply) { tell(reply, {}); });
  object_replies_.take([&](const layer2_ObjectReply& reply) {
    tell(reply, {.sent_time = reply.time,
                 .fresh = reply.fresh,
                 .overrun = reply.overrun,
                 .content = dds::to_core(reply.content)});
  });
}

void FrameClient::look(const Listener& listener) {
  sight_.look();
  take_replies([&](std::uint64_t number, const SendResult& result) {
    if (listener.ended) listener.ended(number, result);
  });
  batches_.take([&](const layer2_FrameBatch& batch) {
    if (listener.batch) listener.batch(batch);
  });
  status_.take([this](const layer2_FrameStatus& sample) { newest_ = sample; });
  if (listener.object) object_status_.take(listener.object);
  if (listener.image) image_reader_.take(listener.image);
}

const std::optional<gateway_BusStatus>& FrameClient::bus_status() {
  bus_reader_.take([this](const gateway_BusStatus& sample) { bus_ = sample; });
  return bus_;
}

void FrameClient::cancel(std::uint64_t request, const gateway::dds::DaemonIdentity& daemon) {
  gateway_JobCancel sample = {};
  std::copy(identity_.begin(), identity_.end(), std::begin(sample.client));
  sample.request = request;
  gateway::dds::set_daemon(daemon, sample);
  (void)cancels_.write(sample);
}

template <class Ready>
void FrameClient::wait_until(milliseconds time, Ready&& ready) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    (void)take_reply(kNobodysRequest);
    if (ready() || options_.stopped() || !daemon_present() || steady_clock::now() >= end) return;
    (void)signal_.wait(static_cast<int>(kLook.count()));
  }
}

template <class Status>
void FrameClient::keep_newest(gateway::dds::Reader<Status>& reader, std::map<unsigned, Status>& newest,
                              milliseconds time) {
  // Those of before come one by one, and nothing tells which is the last.
  auto settled = newest.empty() ? steady_clock::time_point::max() : steady_clock::now();
  wait_until(time, [&] {
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
    wait_until(kDefaultMonitoring, [&] { return writer.matched() != 0; });
}

std::optional<layer2_ProcessImage> FrameClient::image(milliseconds time, bool fresh) {
  if (fresh) image_.reset();
  wait_until(time, [&] {
    image_reader_.take([this](const layer2_ProcessImage& sample) { image_ = sample; });
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
  sight_.look_until_reached(options_, signal_);
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
  if (!events_) events_ = std::make_unique<gateway::dds::Reader<layer2_ModuleEvent>>(participant_, &signal_);
  wait_until(time, [&] { return events_->take(on_event) > 0; });
  return daemon_present();
}

bool FrameClient::receive(milliseconds time, const std::function<void(const layer2_FrameBatch&)>& on_batch) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    (void)take_reply(kNobodysRequest);
    if (batches_.take(on_batch) > 0) return true;
    if (!daemon_present()) return false;
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now());
    if (left <= milliseconds{0} || options_.stopped()) return true;
    (void)signal_.wait(static_cast<int>(std::min(left, kLook).count()));
  }
}

std::optional<layer2_FrameStatus> FrameClient::status(milliseconds time) {
  const auto end = steady_clock::now() + time;
  while (true) {
    signal_.clear();
    (void)take_reply(kNobodysRequest);
    status_.take([this](const layer2_FrameStatus& sample) { newest_ = sample; });
    if (newest_ || options_.stopped() || !daemon_present() || steady_clock::now() >= end) return newest_;
    (void)signal_.wait(static_cast<int>(kLook.count()));
  }
}

}  // namespace layer2::client
