#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/desk/job_desk.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/image_gate.h"
#include "daemon/layer2/gateway/run_lead_gate.h"
#include "layer2.h"
#include "layer2/config/config.h"
#include "layer2/config/running.h"
#include "layer2/dds/convert.h"
#include "layer2/dds/topics.h"
#include "layer2/dds/validate.h"

/// Requests to send a frame, for the desk; daemon/desk/job_protocol.h says what each member is for. Gateway
/// thread only.
namespace cansyncd {

/// What they need to know of the rest of the gateway.
struct SendContext {
  Layer2Exchange& exchange;
  const Layer2Config& config;
  SteadyTime now;
  RequestRules rules;
  ImageGate& image;
  const RunLeadGate& lead;
};

/// "123#0102", as candump writes a frame.
std::string frame_text(const can::Frame& frame);

/// A request, with the memory that its order points to.
struct FrameRequest {
  Layer2Job job;
  std::shared_ptr<const void> memory;
  std::int64_t deadline = 0;                             ///< of a SendOrder: CLOCK_REALTIME (ns); 0: none
  std::shared_ptr<PreparedConfiguration> prepared = {};  ///< of a ControlOrder to configure
  gateway::dds::Problem problem = {};                    ///< it cannot be handed on
};

/// Topic SendRequest.
struct SendTopic {
  using Sample = layer2_SendRequest;
  using Reply = layer2_SendReply;
  static constexpr Right kRight = Right::operate;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return layer2::dds::send_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, layer2::Outcome outcome) {
    return layer2::dds::send_reply(key, {.outcome = outcome}, 0);
  }
  static Reply answer(const gateway::dds::RequestKey& key, const SendDone& done, const FrameRequest& request,
                      std::span<std::uint8_t> /*data*/, const SendContext& /*context*/) {
    const auto* order = std::get_if<layer2::SendOrder>(&request.job);
    const std::size_t frames = order == nullptr ? 1 : order->following.size() + 1;
    return layer2::dds::send_reply(key, done.answer, done.sent_time.count(), frames);
  }
};

/// Topic ControlRequest.
struct ControlTopic {
  using Sample = layer2_ControlRequest;
  using Reply = layer2_ControlReply;
  static constexpr Right kRight = Right::engineer;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return layer2::dds::control_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, layer2::Outcome outcome) {
    return layer2::dds::control_reply(key, outcome);
  }
  static Reply answer(const gateway::dds::RequestKey& key, const SendDone& done,
                      const FrameRequest& /*request*/, std::span<std::uint8_t> /*data*/,
                      const SendContext& /*context*/) {
    return layer2::dds::control_reply(key, done.answer.outcome);
  }
};

/// Topic ObjectRequest.
struct ObjectTopic {
  using Sample = layer2_ObjectRequest;
  using Reply = layer2_ObjectReply;
  static constexpr Right kRight = Right::engineer;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return layer2::dds::object_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, layer2::Outcome outcome) {
    return layer2::dds::object_reply(key, {.outcome = outcome}, 0);
  }
  static Reply answer(const gateway::dds::RequestKey& key, const SendDone& done,
                      const FrameRequest& /*request*/, std::span<std::uint8_t> /*data*/,
                      const SendContext& /*context*/) {
    layer2::ObjectAnswer answer = done.object;
    answer.outcome = done.answer.outcome;
    return layer2::dds::object_reply(key, answer, done.sent_time.count());
  }
};

/// What requests wait for: a queue of the station, the module itself, or a message object.
enum class FrameLane : std::uint8_t { normal, high, control, object };

/// Deletes the frames that wait for their turn: the module is stopped, or its queues are emptied.
struct QueuesEmptied {};

/// The protocol of the desk.
class SendRequests {
 public:
  using Topics = RequestTopics<SendTopic, ControlTopic, ObjectTopic>;
  using Request = FrameRequest;
  using Terminal = SendDone;
  using Outcome = layer2::Outcome;
  using Context = SendContext;
  static constexpr Outcome kCancelled = Outcome::cancelled;
  static constexpr Outcome kStopped = Outcome::stopped;
  using Newer = QueuesEmptied;
  static constexpr Outcome kReplaced = Outcome::deleted;

  /// `running` must outlive the object.
  explicit SendRequests(RunningConfiguration& running) : running_(running) {}

  /// Frames of one client that are given to a queue at a time: those of the longest request, and as many as a client
  /// may have requests open.
  static constexpr unsigned kFramesOfClient = layer2_BATCH;

  /// All frames of a priority share one queue of the station; clients take turns in it, and nobody waits for more than
  /// `kFramesOfClient` of each. A queue that deletes the oldest must be able to overflow.
  LaneLimits lane_limits() const;

  static std::optional<Change> change_of(const layer2_SendRequest& sample, const SendContext& context);
  static std::optional<Change> change_of(const layer2_ControlRequest& sample, const SendContext& context);
  static std::optional<Change> change_of(const layer2_ObjectRequest& sample, const SendContext& context);
  static gateway::dds::Problem check(const layer2_ObjectRequest& sample) {
    return layer2::dds::check(sample);
  }
  static gateway::dds::Problem check(const layer2_ControlRequest& sample) {
    return layer2::dds::check(sample);
  }
  static gateway::dds::Problem check(const layer2_SendRequest& sample) { return layer2::dds::check(sample); }
  std::optional<Request> request_of(const layer2_SendRequest& sample, JobId id,
                                    std::vector<std::uint8_t>& data) const;
  std::optional<Request> request_of(const layer2_ControlRequest& sample, JobId id,
                                    std::vector<std::uint8_t>& /*data*/) const;
  static std::optional<Request> request_of(const layer2_ObjectRequest& sample, JobId id,
                                           std::vector<std::uint8_t>& data);
  /// What is not allowed now, whoever asks.
  static gateway::dds::Problem objection(const Request& request, const SendContext& context);
  /// The desk is a part of the queues: what waits there ends with what waits in the module.
  static std::optional<QueuesEmptied> newer_of(const Request& request, const SendContext& context) noexcept;
  static bool loses_to(const Request& request, QueuesEmptied /*newer*/,
                       const SendContext& /*context*/) noexcept {
    return std::holds_alternative<layer2::SendOrder>(request.job);
  }
  static Lane lane_of(const Request& request) noexcept;
  /// Its frames.
  static unsigned weight_of(const Request& request) noexcept;
  static Effect effect_of(const Request& request) noexcept {
    const bool sends = std::holds_alternative<layer2::SendOrder>(request.job);
    return {sends ? Right::operate : Right::engineer, true};
  }
  static std::string wrong_topic() { return "topic: this one gives no right to send"; }
  static bool hand_on(const Request& request, const SendContext& context);
  static bool hand_on_cancel(JobId id, const SendContext& context) {
    return context.exchange.requests.try_push(CancelOrder{id});
  }

  static JobId id_of(const SendDone& done) noexcept { return done.answer.id; }
  gateway::dds::Problem refusal(const SendDone& done, const Request& request) const;
  gateway::dds::Problem refusal(const SendDone& done, const Request& request,
                                const SendContext& /*context*/) const {
    return refusal(done, request);
  }
  static Outcome outcome_of(const SendDone& done) noexcept { return done.answer.outcome; }
  /// A configuration that was taken over is in force from now on.
  void learn(const Request& request, const SendDone& done);
  static std::string_view name(Outcome outcome) noexcept;
  static bool is_done(Outcome outcome) noexcept { return outcome == Outcome::done; }

 private:
  RunningConfiguration& running_;
};

extern template class JobDesk<SendRequests>;

}  // namespace cansyncd
