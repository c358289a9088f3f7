#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "daemon/desk/access.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/fair_lanes.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/request_topic.h"
#include "dds/denial.h"
#include "dds/request_key.h"

/// What a protocol tells the desk of its requests. All of it runs on the gateway thread.
///
/// A **row** for each topic of requests, a struct without state:
///
///     using Sample, Reply;              // IDL types with a topic_info; both begin with client and request,
///                                       // a Sample has client_name and daemon besides
///     static constexpr Right kRight;    // what the topic gives who may write it, with DDS Security on
///     static Reply refused(key, denial);                      // not accepted; nothing was done
///     static Reply ended(key, outcome);                       // ended without a result of its own
///     static Reply answer(key, terminal, request, data, context);  // ended with one; borrows from `data`,
///                                                             // which is kept until the reply is written
///   and where the topic needs it:
///     static constexpr bool kUrgent = true;             // taken before cancels and what is not urgent
///     static constexpr std::size_t kAtOnce;             // at most so many in a pass
///     static constexpr TopicInfo kEngineerTopic;        // with DDS Security on, read too: gives every right
///     static std::size_t bytes_of(sample);              // memory it needs until it is answered
///     using Progress; static Progress progress(key, done, total);  // how many of those bytes are done
///
/// The **protocol**, a value that the desk keeps:
///
///     using Topics = RequestTopics<Row...>;
///     using Request;     // what is handed on; default-constructible
///     using Terminal;    // what comes back, once for each request that was handed on
///     using Outcome;     // how a request ended
///     using Context;     // what it needs to know in a call; has members `SteadyTime now` and
///                        // `RequestRules rules`
///     static constexpr Outcome kCancelled, kStopped;     // before it was handed on
///     LaneLimits lane_limits();
///     std::optional<Change> change_of(sample, context);  // nothing: it only reads. Of every Sample, also of
///                                                        // one that `check` refuses
///     gateway::dds::Problem check(sample);               // why a field is out of range
///     std::optional<Request> request_of(sample, id, data);  // nothing: of no known kind. `data`:
///                                                           // memory that stays until the request has ended
///     Lane lane_of(request);
///     Effect effect_of(request);        // right it needs, whether it changes something
///     std::string wrong_topic();        // why a request is not taken from a topic that gives less
///     bool hand_on(request, context);   // false: no room now; tried again within 10 ms
///     bool hand_on_cancel(id, context); // the request ends by itself, soon; an unknown one is ignored
///     JobId id_of(terminal);
///     gateway::dds::Problem refusal(terminal, request, context);  // why it was not taken after all
///     Outcome outcome_of(terminal);     // of one that was taken
///     std::string_view name(outcome);   // for the audit trail
///     bool is_done(outcome);            // as it was asked for
///   and what not every protocol has:
///     unsigned weight_of(request);      // what it counts for its client in its lane, over 0; else 1
///     using StateBefore; StateBefore state(context);     // kept with a request for `before`
///     std::string before(request, state_before);         // the value it would replace; else "not known"
///     void ended(request, outcome);                      // after its entry in the audit trail
///     void learn(request, terminal);                     // after `ended`, when it was handed on
///     gateway::dds::Problem objection(request, context);  // a value that is not allowed after all
///     using Newer; static constexpr Outcome kReplaced;   // requests that others take the place of:
///     std::optional<Newer> newer_of(request, context);   //   what this one does to those that wait
///     bool loses_to(request, newer, context);            //   whether this one, waiting, loses its turn
///     std::string open_text(request, context);           // what is asked for, while it is open; else what
///                                                        // `change_of` says
///     std::string text(request, context); void set_id(request, id);   // needed by `JobDesk::give`
namespace cansyncd {

/// Limits of requests that change while the daemon runs.
struct RequestRules {
  std::chrono::milliseconds maximum_age{0};  ///< of a request when it arrives; 0: any
  bool read_only = false;                    ///< nothing is taken that changes something
};

/// The topics of requests of a protocol, made with these rows.
template <class... Rows>
struct RequestTopics {
  static_assert(sizeof...(Rows) > 0, "without a topic of requests there is nothing to do");
  /// Throws gateway::dds::SetupError.
  explicit RequestTopics(const TopicSetup& setup) : all(each<Rows>(setup)...) {}
  std::tuple<RequestTopic<Rows>...> all;

 private:
  template <class Row>
  static const TopicSetup& each(const TopicSetup& setup) noexcept {
    return setup;
  }
};

/// A row that fits the protocol.
template <class P, class Row>
concept RowOf = requires(P& protocol, const typename Row::Sample& sample, const typename P::Context& context,
                         const typename P::Terminal& terminal, const typename P::Request& request,
                         typename P::Outcome outcome, const gateway::dds::RequestKey& key,
                         const gateway::dds::Denial& denial, std::vector<std::uint8_t>& data, JobId id) {
  { Row::kRight } -> std::convertible_to<Right>;
  { Row::refused(key, denial) } -> std::same_as<typename Row::Reply>;
  { Row::ended(key, outcome) } -> std::same_as<typename Row::Reply>;
  { Row::answer(key, terminal, request, std::span(data), context) } -> std::same_as<typename Row::Reply>;
  { protocol.change_of(sample, context) } -> std::same_as<std::optional<Change>>;
  { protocol.check(sample) } -> std::same_as<gateway::dds::Problem>;
  { protocol.request_of(sample, id, data) } -> std::same_as<std::optional<typename P::Request>>;
};

/// True when every row fits the protocol.
template <class P, class Topics>
inline constexpr bool kRowsFit = false;
template <class P, class... Rows>
inline constexpr bool kRowsFit<P, RequestTopics<Rows...>> = (RowOf<P, Rows> && ...);

/// A protocol whose requests a `JobDesk` can take.
template <class P>
concept RequestProtocol = std::default_initializable<typename P::Request> &&
    kRowsFit<P, typename P::Topics> &&
    requires(P& protocol, const typename P::Context& context, const typename P::Request& request,
             const typename P::Terminal& terminal, typename P::Outcome outcome, JobId id) {
  { P::kCancelled } -> std::convertible_to<typename P::Outcome>;
  { P::kStopped } -> std::convertible_to<typename P::Outcome>;
  { context.now } -> std::convertible_to<SteadyTime>;
  { context.rules } -> std::convertible_to<RequestRules>;
  { protocol.lane_limits() } -> std::same_as<LaneLimits>;
  { protocol.lane_of(request) } -> std::same_as<Lane>;
  { protocol.effect_of(request) } -> std::same_as<Effect>;
  { protocol.wrong_topic() } -> std::convertible_to<std::string>;
  { protocol.hand_on(request, context) } -> std::same_as<bool>;
  { protocol.hand_on_cancel(id, context) } -> std::same_as<bool>;
  { protocol.id_of(terminal) } -> std::same_as<JobId>;
  { protocol.refusal(terminal, request, context) } -> std::same_as<gateway::dds::Problem>;
  { protocol.outcome_of(terminal) } -> std::same_as<typename P::Outcome>;
  { protocol.name(outcome) } -> std::convertible_to<std::string_view>;
  { protocol.is_done(outcome) } -> std::same_as<bool>;
};

/// A protocol that keeps what was when a request was taken.
template <class P>
concept KeepsState = requires {
  typename P::StateBefore;
};
/// A protocol some requests of which take the place of others that wait.
template <class P>
concept Replaces = requires {
  typename P::Newer;
};
/// A protocol with requests of the daemon itself.
template <class P>
concept GivesOwn = requires(P& protocol, typename P::Request& request, const typename P::Context& context) {
  { protocol.text(request, context) } -> std::convertible_to<std::string>;
  protocol.set_id(request, JobId{});
};

/// Stands where a protocol has nothing.
struct NotThere {};
template <class P>
struct StateBeforeOf {
  using Type = NotThere;
};
template <KeepsState P>
struct StateBeforeOf<P> {
  using Type = typename P::StateBefore;
};
template <class P>
struct NewerOf {
  using Type = NotThere;
};
template <Replaces P>
struct NewerOf<P> {
  using Type = typename P::Newer;
};

}  // namespace cansyncd
