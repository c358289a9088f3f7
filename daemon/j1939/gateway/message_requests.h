#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/desk/job_desk.h"
#include "daemon/j1939/exchange.h"
#include "j1939.h"
#include "j1939/config/config.h"
#include "j1939/dds/convert.h"
#include "j1939/dds/texts.h"
#include "j1939/dds/topics.h"
#include "j1939/dds/validate.h"

/// Requests to send a message or to ask for one, for the desk; daemon/desk/job_protocol.h says what each
/// member is for. Gateway thread only.
namespace cansyncd {

/// What they need to know of the rest of the gateway.
struct MessageContext {
  J1939Exchange& exchange;
  const J1939Config& config;
  SteadyTime now;
  RequestRules rules;
};

/// Topic MessageRequest.
struct MessageTopic {
  using Sample = j1939_MessageRequest;
  using Reply = j1939_MessageReply;
  static constexpr Right kRight = Right::operate;

  static std::size_t bytes_of(const Sample& sample) noexcept {
    return sample.kind == j1939_MESSAGE_ASK ? j1939::kMostBytes : j1939::dds::bytes_of(sample);
  }
  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return j1939::dds::message_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, j1939::Outcome outcome) {
    return j1939::dds::message_reply(key, {.outcome = outcome}, 0, {});
  }
  static Reply answer(const gateway::dds::RequestKey& key, const MessageDone& done,
                      const j1939::Order& /*request*/, std::span<std::uint8_t> data,
                      const MessageContext& /*context*/) {
    return j1939::dds::message_reply(key, done.answer, done.sent_time.count(), data);
  }
};

/// The protocol of the desk.
class MessageRequests {
 public:
  using Topics = RequestTopics<MessageTopic>;
  using Request = j1939::Order;
  using Terminal = MessageDone;
  using Outcome = j1939::Outcome;
  using Context = MessageContext;
  static constexpr Outcome kCancelled = Outcome::cancelled;
  static constexpr Outcome kStopped = Outcome::stopped;

  MessageRequests(const MessageSendConfig& config, std::size_t most) : config_(config), most_(most) {}

  /// All messages share the one queue of the node, all requests for groups its places for them; clients take
  /// turns in each. What nobody answers stays for up to an hour, so one client has at most half.
  LaneLimits lane_limits() const {
    const auto shared = [](unsigned places) { return LaneLimit{places, places, (places + 1) / 2}; };
    return {shared(config_.queue), shared(j1939::kMostRequests)};
  }

  static std::optional<Change> change_of(const j1939_MessageRequest& sample, const MessageContext& context);
  static gateway::dds::Problem check(const j1939_MessageRequest& sample) { return j1939::dds::check(sample); }
  std::optional<Request> request_of(const j1939_MessageRequest& sample, JobId id,
                                    std::vector<std::uint8_t>& data) const {
    return j1939::dds::to_core(sample, id, config_.timeout, most_, data);
  }
  static Lane lane_of(const Request& request) noexcept { return {request.kind, 0}; }
  static Effect effect_of(const Request& request) noexcept {
    return {Right::operate, request.kind == j1939::OrderKind::send || erases(request.number)};
  }
  static std::string wrong_topic() { return "topic: this one gives no right to send"; }
  static bool hand_on(const Request& request, const MessageContext& context) {
    return context.exchange.requests.try_push(request);
  }
  static bool hand_on_cancel(JobId id, const MessageContext& context) {
    return context.exchange.requests.try_push(CancelMessage{id});
  }

  static JobId id_of(const MessageDone& done) noexcept { return done.answer.id; }
  gateway::dds::Problem refusal(const MessageDone& done, const Request& /*request*/,
                                const MessageContext& /*context*/) const {
    return j1939::dds::explain(done.refusal, config_.queue, most_);
  }
  static Outcome outcome_of(const MessageDone& done) noexcept { return done.answer.outcome; }
  static std::string_view name(Outcome outcome) noexcept { return j1939::dds::name_of(outcome); }
  static bool is_done(Outcome outcome) noexcept { return outcome == Outcome::done; }

 private:
  /// Asking for the group makes the other node erase its faults (J1939-73, 5.7.3 and 5.7.11).
  static constexpr bool erases(j1939::Pgn number) noexcept {
    return number == j1939::pgn::kErasePreviousFaults || number == j1939::pgn::kEraseActiveFaults;
  }

  MessageSendConfig config_;
  std::size_t most_;  ///< bytes of a message
};

extern template class JobDesk<MessageRequests>;

}  // namespace cansyncd
