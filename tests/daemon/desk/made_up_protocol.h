#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/desk/job_desk.h"
#include "daemon/desk/job_desk_answers.h"
#include "daemon/desk/job_desk_oversight.h"
#include "daemon/desk/job_desk_requests.h"
#include "dds/bounded_text.h"
#include "dds/topic.h"
#include "made_up.h"

namespace gateway::dds {

template <>
inline constexpr TopicInfo topic_info<made_up_Wish> = {"Wish", &made_up_Wish_desc, kFromClients,
                                                       kind::request()};
template <>
inline constexpr TopicInfo topic_info<made_up_Answer> = {"Answer", &made_up_Answer_desc, kFromDaemon,
                                                         kind::reply(256, 128)};

}  // namespace gateway::dds

namespace cansyncd::made_up {

/// A wish of no kind that the protocol knows.
inline constexpr std::uint32_t kUnknownKind = 97;

/// What was handed on: a number, of which 100 and more are refused.
struct Wish {
  JobId id = 0;
  std::uint32_t number = 0;
};

/// How it ended; refused with a reason.
struct Granted {
  JobId id = 0;
  gateway::dds::Problem refused;
};

enum class Ending : std::uint8_t { granted, cancelled, stopped };

/// Whoever executes wishes: takes `room` of them.
struct Executor {
  std::size_t room = 1000;
  std::deque<Wish> wishes;
  std::vector<JobId> cancelled;
};

struct Context {
  Executor& executor;
  SteadyTime now;
  RequestRules rules;
};

struct WishTopic {
  using Sample = made_up_Wish;
  using Reply = made_up_Answer;
  static constexpr Right kRight = Right::operate;

  static Reply reply(const gateway::dds::RequestKey& key, gateway_ReplyCode code, std::string_view reason) {
    Reply reply = {};
    std::copy(key.client.begin(), key.client.end(), std::begin(reply.client));
    reply.request = key.request;
    reply.code = code;
    gateway::dds::copy_text(reason, reply.reason);
    return reply;
  }
  static Reply refused(const gateway::dds::RequestKey& key, const gateway::dds::Denial& denial) {
    Reply refusal = reply(key, gateway_REPLY_REFUSED, denial.reason);
    refusal.cause = denial.cause;
    return refusal;
  }
  static Reply ended(const gateway::dds::RequestKey& key, Ending ending) {
    const bool cancelled = ending == Ending::cancelled;
    return reply(key, cancelled ? gateway_REPLY_CANCELLED : gateway_REPLY_MASTER_STOPPED,
                 cancelled ? "cancelled" : "stopped");
  }
  static Reply answer(const gateway::dds::RequestKey& key, const Granted& /*granted*/, const Wish& /*wish*/,
                      std::span<std::uint8_t> /*data*/, const Context& /*context*/) {
    return reply(key, gateway_REPLY_DONE, "");
  }
};

/// No more than what every protocol must provide.
struct Protocol {
  using Topics = RequestTopics<WishTopic>;
  using Request = Wish;
  using Terminal = Granted;
  using Outcome = Ending;
  using Context = made_up::Context;
  static constexpr Ending kCancelled = Ending::cancelled;
  static constexpr Ending kStopped = Ending::stopped;
  enum class Lanes : std::uint8_t { all };

  static LaneLimits lane_limits() { return {{2}}; }
  static std::optional<Change> change_of(const made_up_Wish& sample, const Context& /*context*/) {
    return Change{"wish", -1, "", std::to_string(sample.number)};
  }
  static gateway::dds::Problem check(const made_up_Wish& sample) {
    if (sample.number < 100) return std::nullopt;
    return gateway::dds::Denial{gateway_CAUSE_FIELD, "number: allowed 0..99"};
  }
  static std::optional<Wish> request_of(const made_up_Wish& sample, JobId id, std::vector<std::uint8_t>&) {
    return sample.number == kUnknownKind ? std::nullopt : std::optional(Wish{id, sample.number});
  }
  static Lane lane_of(const Wish& /*wish*/) { return {Lanes::all, 0}; }
  static Effect effect_of(const Wish& /*wish*/) { return {Right::operate, true}; }
  static std::string wrong_topic() { return "another topic"; }
  static bool hand_on(const Wish& wish, const Context& context) {
    if (context.executor.wishes.size() >= context.executor.room) return false;
    context.executor.wishes.push_back(wish);
    return true;
  }
  static bool hand_on_cancel(JobId id, const Context& context) {
    context.executor.cancelled.push_back(id);
    return true;
  }
  static JobId id_of(const Granted& granted) { return granted.id; }
  static gateway::dds::Problem refusal(const Granted& granted, const Wish& /*wish*/,
                                       const Context& /*context*/) {
    return granted.refused;
  }
  static Ending outcome_of(const Granted& /*granted*/) { return Ending::granted; }
  static std::string_view name(Ending ending) {
    return ending == Ending::granted ? "granted" : "not granted";
  }
  static bool is_done(Ending ending) { return ending == Ending::granted; }
};

}  // namespace cansyncd::made_up
