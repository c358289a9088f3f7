#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cansync.h"
#include "cansync/config/config.h"
#include "cansync/dds/validate.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/requests/access.h"
#include "daemon/cansync/requests/lanes.h"
#include "daemon/cansync/requests/request_audit.h"
#include "daemon/cansync/requests/topics.h"
#include "daemon/desk/job_desk.h"

namespace cansyncd {

/// What a request, or the loss of reference values, does to those that wait.
struct Superseded {
  cansync::SlaveMask words;    ///< control words to these slaves are replaced
  cansync::SlaveMask stopped;  ///< so is what would enable one of these after its stop
};

/// CANsync's requests, for the desk; daemon/desk/job_protocol.h says what each member is for. What there is
/// to know of a kind of request stands in its row in kinds.h. Gateway thread only.
class CansyncRequests {
 public:
  using Topics = RequestTopics<CommandTopic, ParameterTopic, TransferTopic>;
  using Request = cansyncd::Request;
  using Terminal = cansyncd::Terminal;
  using Outcome = cansync::Outcome;
  using Context = JobContext;
  using StateBefore = cansync::State;
  using Newer = Superseded;
  static constexpr Outcome kCancelled = Outcome::cancelled;
  static constexpr Outcome kStopped = Outcome::master_stopped;
  static constexpr Outcome kReplaced = Outcome::replaced;

  /// `audit` must outlive the object.
  CansyncRequests(const Config& config, RequestAudit& audit)
      : limits_(cansync::dds::limits_of(config.master)),
        channel_(config.master.command_channel),
        audit_(audit) {}

  LaneLimits lane_limits() const { return cansyncd::lane_limits(channel_); }

  // --- from a topic

  static std::optional<Change> change_of(const cansync_Command& sample, const JobContext& context);
  static std::optional<Change> change_of(const cansync_ParameterRequest& sample, const JobContext& context);
  static std::optional<Change> change_of(const cansync_TransferRequest& sample, const JobContext& context);
  template <class Sample>
  gateway::dds::Problem check(const Sample& sample) const {
    return cansync::dds::check(sample, limits_);
  }
  static std::optional<Request> request_of(const cansync_Command& sample, JobId id,
                                           std::vector<std::uint8_t>& data);
  static std::optional<Request> request_of(const cansync_ParameterRequest& sample, JobId id,
                                           std::vector<std::uint8_t>& data);
  static std::optional<Request> request_of(const cansync_TransferRequest& sample, JobId id,
                                           std::vector<std::uint8_t>& data);
  static cansync::State state(const JobContext& context) noexcept { return context.line.state; }

  // --- of a request

  static Lane lane_of(const Request& request);
  static Effect effect_of(const Request& request) { return cansyncd::effect_of(request); }
  static std::string wrong_topic();
  static gateway::dds::Problem objection(const Request& request, const JobContext& context);
  static std::optional<Superseded> newer_of(const Request& request, const JobContext& context);
  static bool loses_to(const Request& request, const Superseded& newer, const JobContext& context);
  static std::string text(const Request& request, const JobContext& context);
  static std::string open_text(const Request& request, const JobContext& context);
  static void set_id(Request& request, JobId id);
  static bool hand_on(const Request& request, const JobContext& context) {
    return context.exchange.requests.try_push(request);
  }
  static bool hand_on_cancel(JobId id, const JobContext& context) {
    return context.exchange.requests.try_push(Cancel{id});
  }

  // --- of its end

  static JobId id_of(const Terminal& terminal);
  static gateway::dds::Problem refusal(const Terminal& terminal, const Request& request,
                                       const JobContext& context);
  static Outcome outcome_of(const Terminal& terminal) { return cansyncd::outcome_of(terminal); }
  static std::string_view name(Outcome outcome) noexcept { return cansync::name(outcome); }
  static bool is_done(Outcome outcome) noexcept { return outcome == Outcome::done; }
  std::string before(const Request& request, cansync::State state) const {
    return audit_.before(request, state);
  }
  void ended(const Request& request, Outcome outcome) { audit_.remember(request, outcome); }
  void learn(const Request& request, const Terminal& terminal);

 private:
  cansync::dds::Limits limits_;
  cansync::CommandChannelSettings channel_;
  RequestAudit& audit_;
};

extern template class JobDesk<CansyncRequests>;

}  // namespace cansyncd
