#include "daemon/cansync/gateway/gateway.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "cansync/config/options.h"
#include "daemon/cansync/requests/access.h"
#include "daemon/cansync/requests/gateway_requests.h"
#include "daemon/cansync/status/master_metrics.h"
#include "daemon/cansync/status/status_text.h"

namespace cansyncd {
namespace {

using std::chrono::steady_clock;

/// Takes from `to` what may change while running.
void take_changeable(const Config& to, Config& config) {
  config.references = to.references;
  config.reference_limits = to.reference_limits;
  config.slaves = to.slaves;
  config.access = to.access;
  config.failsafe.reference_max_age = to.failsafe.reference_max_age;
  config.dds.request_max_age = to.dds.request_max_age;
  cansync::put_in_force(cansync::in_force(to.master), config.master);
}

}  // namespace

Gateway::Gateway(const Config& config, Exchange& exchange, const gateway::dds::Participant& participant,
                 JournalSink& journal, const DaemonIdentity& identity)
    : GatewayBase(config, exchange, participant, journal, identity, kMasterProtocol, cansync::kSlaves),
      state_(participant, config, identity),
      audit_(trail_, config),
      failsafe_(events_, audit_, config),
      references_(participant, signal_, events_, config, identity, exchange_),
      jobs_(participant, signal_, events_, trail_, CansyncRequests(config, audit_), identity,
            !config.dds.security.empty()) {
  state_.set_givers(references_.givers());
  jobs_.set_read_by_all(common_.gateway_writer());
}

Gateway::~Gateway() {
  stop();
}

std::string Gateway::metrics_text(std::uint64_t write_failures) const {
  return master_metrics_text(common_.told(), state_.told(), write_failures);
}

JobContext Gateway::context(SteadyTime now) {
  const MasterSnapshot& master = state_.master();
  return {exchange_,
          config_,
          {master.state, master.when.interval, master.responding, master.released,
           state_.settings().mapping_number, state_.settings().reference_mapping, master.access,
           master.waits_for_upper_sync},
          now,
          {config_.dds.request_max_age, config_.access.read_only}};
}

SteadyTime Gateway::pass(bool samples_may_wait) {
  const SteadyTime now = steady_clock::now();
  take_configuration(now);
  const SteadyTime due = state_.step(exchange_, now);
  events_.set_interval(state_.master().when.interval);
  const JobContext jobs = context(now);
  take_reports(jobs);
  references_.set_line(state_.master().when);
  references_.set_lead_axis(state_.master().lead_axis);
  references_.set_mapping_number(state_.settings().mapping_number);
  references_.watch(state_.master().release, now);
  posted_.publish(events_, now);
  if (samples_may_wait) {
    second_daemon_.look(now);
    // Both take a bounded number, so that no writer keeps this thread from the rest of its work.
    const bool more_references = references_.take_samples(now);
    const bool more_requests = jobs_.take_requests(jobs);
    if (more_references || more_requests) signal_.raise();
  }
  const auto references_due = references_.tick(now);
  references_.push_stops();
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    if (references_.take_reaction(channel)) {
      failsafe_.start(channel, config_, now);
      // What they had asked for before the loss must not follow the word.
      jobs_.replace_waiting({failsafe_.slaves(), failsafe_.slaves()}, jobs);
    }
    if (references_.take_return(channel)) failsafe_.values_back(channel, config_, now);
  }
  const auto failsafe_due = failsafe_.push(exchange_, now);
  const MasterSnapshot& master = state_.master();
  const SteadyTime common_due =
      tell_common({master.controller, master.timestamps, master.sync, master.missed_syncs,
                   master.lost_reports, master.state == cansync::State::active_master},
                  jobs_, now);
  return earliest(std::min(due, common_due),
                  {jobs_.retry(jobs), references_due, failsafe_due, tell_syncs(now),
                   status_line_.step([&] { return status_text(master, config_); }, now)},
                  now);
}

void Gateway::take_reports(const JobContext& context) {
  Terminal terminal;
  while (exchange_.terminals.try_pop(terminal)) {
    state_.tell_settings(exchange_, context.now);
    if (!failsafe_.finish(terminal, config_, context.line, context.now)) jobs_.finish(terminal, context);
  }
  Report report;
  while (exchange_.reports.try_pop(report)) {
    if (const auto* progress = std::get_if<TransferProgress>(&report)) {
      jobs_.progress(progress->id, progress->bytes, context.now);
    } else if (const auto* refused = std::get_if<ReferenceRefused>(&report)) {
      references_.refused(*refused, config_, context.line, context.now);
    } else {
      take_event(report, context.now);
    }
  }
}

void Gateway::take_event(const Report& report, SteadyTime now) {
  // A computer that is too slow skips edges all the time; that must not push everything else out of the
  // history.
  const auto* missed = std::get_if<SyncsMissed>(&report);
  if (missed != nullptr && !missed_syncs_.add(missed->count, now)) return;
  if (const auto event = describe(report, config_, link())) events_.publish(*event, now);
}

std::optional<SteadyTime> Gateway::tell_syncs(SteadyTime now) {
  const std::uint64_t missed = missed_syncs_.take_over(now);
  if (missed != 0) {
    events_.publish(
        {gateway_SEVERITY_INFO, "syncs_kept", -1,
         fmt::format("no SYNC edge was skipped for {} s; {} were before", kSyncQuiet.count(), missed),
         std::nullopt},
        now);
  }
  return missed_syncs_.next();
}

void Gateway::take_configuration(SteadyTime now) {
  const auto taken = new_configuration_.take();
  if (!taken) return;
  for (const Request& request : changes(config_, *taken)) jobs_.give(request);
  take_changeable(*taken, config_);
  state_.set_names(config_);
  common_.set_access(config_.access);
  references_.set_maximum_age(config_.failsafe.reference_max_age);
  references_.set_limits(config_);
  references_.set_refusal(read_only_refusal_of_references(config_));
  tell_reloaded(now);
}

void Gateway::end() {
  (void)state_.step(exchange_, steady_clock::now());
  take_reports(context(steady_clock::now()));
  posted_.publish(events_, steady_clock::now());
  jobs_.stop_and_deliver(signal_, [this] { return context(steady_clock::now()); });
}

}  // namespace cansyncd
