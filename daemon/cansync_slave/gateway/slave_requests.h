#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "can/job_ending.h"
#include "cansync_slave.h"
#include "cansync_slave/config/config.h"
#include "cansync_slave/dds/convert.h"
#include "cansync_slave/dds/topics.h"
#include "cansync_slave/dds/validate.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/desk/job_desk.h"

/// What programs ask of the slave itself, for the desk; daemon/desk/job_protocol.h says what each member is
/// for. Gateway thread only.
namespace cansyncd {

/// What they need to know of the rest of the gateway.
struct SlaveContext {
  SlaveExchange& exchange;
  const SlaveRoleConfig& config;
  SteadyTime now;
  RequestRules rules;
};

/// How a command ended that was not refused. `no_answer`: it was begun, and its end is not known.
enum class SlaveOutcome : std::uint8_t { done, cancelled, stopped, no_answer };

/// The outcome of a command without an end (can/job_ending.h). Pure.
SlaveOutcome slave_outcome_of(can::JobKnown known, can::JobEnd end) noexcept;

/// The outcome of a command that was not refused. Pure.
SlaveOutcome slave_outcome_of(const SlaveOrderDone& done) noexcept;

/// Reply code of an outcome. Pure.
gateway_ReplyCode reply_code_of(SlaveOutcome outcome) noexcept;

/// Topic SlaveCommand.
struct SlaveCommandTopic {
  using Sample = cansync_slave_SlaveCommand;
  using Reply = cansync_slave_SlaveCommandReply;
  static constexpr Right kRight = Right::engineer;

  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    return cansync_slave::dds::command_refused(key, denial);
  }
  static Reply ended(const gateway::dds::RequestKey& key, SlaveOutcome outcome);
  static Reply answer(const gateway::dds::RequestKey& key, const SlaveOrderDone& done,
                      const SlaveOrder& /*request*/, std::span<std::uint8_t> /*data*/,
                      const SlaveContext& /*context*/) {
    return ended(key, slave_outcome_of(done));
  }
};

/// They wait for the slave alone.
enum class SlaveLane : std::uint8_t { slave };

/// The protocol of the desk.
class SlaveRequests {
 public:
  using Topics = RequestTopics<SlaveCommandTopic>;
  using Request = SlaveOrder;
  using Terminal = SlaveOrderDone;
  using Outcome = SlaveOutcome;
  using Context = SlaveContext;
  static constexpr Outcome kCancelled = Outcome::cancelled;
  static constexpr Outcome kStopped = Outcome::stopped;

  static LaneLimits lane_limits();
  static std::optional<Change> change_of(const cansync_slave_SlaveCommand& sample,
                                         const SlaveContext& context);
  static gateway::dds::Problem check(const cansync_slave_SlaveCommand& sample) {
    return cansync_slave::dds::check(sample);
  }
  static std::optional<Request> request_of(const cansync_slave_SlaveCommand& sample, JobId id,
                                           std::vector<std::uint8_t>& data);
  static gateway::dds::Problem objection(const Request& request, const SlaveContext& context);
  static Lane lane_of(const Request& /*request*/) noexcept { return {SlaveLane::slave, 0}; }
  static Effect effect_of(const Request& /*request*/) noexcept { return {Right::engineer, true}; }
  static std::string wrong_topic() { return "topic: this one gives no right to set the slave"; }
  static bool hand_on(const Request& request, const SlaveContext& context) {
    return context.exchange.commands.try_push(request);
  }
  /// It ends by itself, within an interval.
  static bool hand_on_cancel(JobId /*id*/, const SlaveContext& /*context*/) { return true; }

  static JobId id_of(const SlaveOrderDone& done) noexcept;
  static gateway::dds::Problem refusal(const SlaveOrderDone& done, const Request& request,
                                       const SlaveContext& context);
  static Outcome outcome_of(const SlaveOrderDone& done) noexcept { return slave_outcome_of(done); }
  static std::string_view name(Outcome outcome) noexcept;
  static bool is_done(Outcome outcome) noexcept { return outcome == Outcome::done; }
};

extern template class JobDesk<SlaveRequests>;

}  // namespace cansyncd
