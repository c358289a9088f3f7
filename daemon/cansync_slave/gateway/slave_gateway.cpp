#include "daemon/cansync_slave/gateway/slave_gateway.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "cansync_slave/config/options.h"
#include "cansync_slave/dds/convert.h"
#include "cansync_slave/dds/topics.h"
#include "daemon/cansync_slave/gateway/job_samples.h"
#include "daemon/cansync_slave/gateway/slave_events.h"
#include "daemon/cansync_slave/gateway/slave_metrics.h"
#include "daemon/cansync_slave/gateway/slave_status.h"

namespace cansyncd {
namespace {

using std::chrono::steady_clock;

/// Reports told in one pass: the rest of the gateway must not wait behind a line that never rests.
constexpr unsigned kReportsAtOnce = 256;

cansync_slave_ActionKind to_idl(SlaveAction kind) noexcept {
  switch (kind) {
    case SlaveAction::control_word:
      return cansync_slave_ACTION_CONTROL_WORD;
    case SlaveAction::sync_mode:
      return cansync_slave_ACTION_SYNC_MODE;
    case SlaveAction::user:
      break;
  }
  return cansync_slave_ACTION_USER;
}

cansync_slave_ActionReceived action_received(const ActionReport& report) noexcept {
  cansync_slave_ActionReceived sample = {};
  sample.number = report.number;
  sample.time = report.when.wall_clock.count();
  sample.interval = report.when.interval;
  sample.kind = to_idl(report.kind);
  sample.command = report.action.command;
  sample.data_byte = report.action.data_byte;
  sample.data_word = report.action.data_word;
  return sample;
}

}  // namespace

SlaveGateway::SlaveGateway(const SlaveRoleConfig& config, SlaveExchange& exchange,
                           const gateway::dds::Participant& participant, JournalSink& journal,
                           const DaemonIdentity& identity)
    : GatewayBase(config, exchange, participant, journal, identity, kSlaveProtocol, 0),
      identity_(identity),
      releases_(participant, signal_, events_, identity, exchange),
      application_(participant, signal_, events_, identity, config.status_parameter, exchange),
      action_reports_(exchange),
      commands_(participant, signal_, events_, trail_, SlaveRequests(), identity,
                !config.dds.security.empty()),
      references_(participant, 0, &signal_),
      monitored_(participant, 0, &signal_),
      actions_(participant, 0, &signal_),
      parameter_jobs_(participant, 0, &signal_),
      block_jobs_(participant, 0, &signal_),
      status_(participant, 0, &signal_) {
  releases_.set_read_only(config.access.read_only, steady_clock::now());
  application_.set_read_only(config.access.read_only, steady_clock::now());
  commands_.set_read_by_all(common_.gateway_writer());
}

SlaveGateway::~SlaveGateway() {
  stop();
}

void SlaveGateway::start() {
  for (std::uint8_t slave = 0; slave < cansync::kSlaves; ++slave)
    publish_monitored(*cansync::SlaveNumber::from(slave), {});
  GatewayBase::start();
}

std::string SlaveGateway::metrics_text(std::uint64_t write_failures) const {
  return slave_metrics_text(common_.told(), told_status_, write_failures);
}

SteadyTime SlaveGateway::pass(bool samples_may_wait) {
  const SteadyTime now = steady_clock::now();
  if (take_access(now)) {
    releases_.set_read_only(config_.access.read_only, now);
    application_.set_read_only(config_.access.read_only, now);
  }
  take_actions();
  const bool more = take_reports(now);
  take_jobs();
  take_done(now);
  posted_.publish(events_, now);
  if (samples_may_wait) {
    second_daemon_.look(now);
    if (releases_.take_samples(now, wall_clock_now())) signal_.raise();
    if (application_.take_samples(now)) signal_.raise();
    if (commands_.take_requests(context(now))) signal_.raise();
  }
  const SteadyTime status_due = publish_status(now);
  const SteadyTime due =
      earliest(status_due,
               {releases_.tick(now), application_.tick(now), commands_.retry(context(now)),
                status_line_.step([this] { return slave_sentence(snapshot_, config_); }, now)},
               now);
  return more ? now : due;
}

bool SlaveGateway::take_reports(SteadyTime now) {
  SlaveSideReport report;
  for (unsigned i = 0; i < kReportsAtOnce; ++i) {
    if (!exchange_.reports.try_pop(report)) return false;
    publish(report, now);
  }
  return true;
}

void SlaveGateway::take_actions() {
  action_reports_.take([this](const ActionReport& report) { (void)actions_.write(action_received(report)); });
}

void SlaveGateway::take_jobs() {
  ServiceReport report;
  for (unsigned i = 0; i < SlaveExchange::kJobs && exchange_.jobs.try_pop(report); ++i) {
    if (const auto* job = std::get_if<JobReport>(&report)) {
      if (job->step == JobReport::Step::asked) job_applications_.given(job->job.id, application_.guid());
      (void)parameter_jobs_.write(parameter_job(*job, identity_, job_applications_.of(job->job.id)));
    } else if (auto* block = std::get_if<BlockReport>(&report)) {
      if (block->step == BlockReport::Step::begun)
        block_applications_.given(block->block.id, application_.guid());
      (void)block_jobs_.write(block_job(*block, identity_, block_applications_.of(block->block.id)));
    }
  }
}

SlaveContext SlaveGateway::context(SteadyTime now) const {
  return {exchange_, config_, now, {config_.dds.request_max_age, config_.access.read_only}};
}

void SlaveGateway::take_done(SteadyTime now) {
  SlaveOrderDone done;
  while (exchange_.done.try_pop(done)) {
    if (done.refusal == SlaveRefusal::none && !done.stopped) {
      take_over(done.order);
      next_status_ = now;
      (void)publish_status(now);
    }
    commands_.finish(done, context(now));
  }
}

void SlaveGateway::take_over(const SlaveOrder& order) {
  if (const auto* mapping = std::get_if<SlaveMappingOrder>(&order)) {
    config_.slave.reference_mapping = mapping->reference;
    config_.slave.actual_mapping = mapping->actual;
  } else if (const auto* listen = std::get_if<SlaveListenOrder>(&order)) {
    config_.slave.monitored[listen->other.value()] = listen->mapping;
    (void)monitored_.write(cansync_slave::dds::monitored_values(
        listen->other, {}, listen->mapping.value_or(cansync::ProcessMapping{})));
  }
}

void SlaveGateway::publish(const SlaveSideReport& report, SteadyTime now) {
  if (const auto* references = std::get_if<ReferencesReport>(&report)) {
    (void)references_.write(
        cansync_slave::dds::references_received(references->values, snapshot_.lost_references));
  } else if (const auto* monitored = std::get_if<MonitoredReport>(&report)) {
    publish_monitored(monitored->slave, monitored->values);
  } else if (const auto event = event_of(report, config_)) {
    events_.publish(*event, now);
  }
}

void SlaveGateway::publish_monitored(cansync::SlaveNumber slave,
                                     const cansync_slave::ReceivedValues& values) {
  if (const auto& mapping = config_.slave.monitored[slave.value()])
    (void)monitored_.write(cansync_slave::dds::monitored_values(slave, values, *mapping));
}

SteadyTime SlaveGateway::publish_status(SteadyTime now) {
  const SlaveSnapshot before = snapshot_;
  if (exchange_.status.read(snapshot_)) {
    events_.set_interval(snapshot_.interval);
    tell_bus(before.controller, snapshot_.controller, now);
  }
  const SteadyTime common_due = tell_common({.controller = snapshot_.controller,
                                             .timestamps = snapshot_.timestamps,
                                             .sync = snapshot_.sync,
                                             .missed_syncs = snapshot_.missing_edges,
                                             .lost_reports = snapshot_.lost_reports,
                                             .in_run = snapshot_.activated},
                                            commands_, now);
  const bool owner_changed =
      ownership_.take(application_.arbiter(), releases_.arbiter(0), releases_.arbiter(1));
  if (now < next_status_ && !differs(before, snapshot_) && !owner_changed)
    return std::min(common_due, next_status_);
  next_status_ = now + kStatusPeriod;
  told_status_ = slave_side_status(snapshot_, config_);
  put_application(application_.arbiter(), application_.taken(), told_status_);
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel)
    put_ownership(releases_.arbiter(channel), told_status_.actual_ownership[channel]);
  (void)status_.write(told_status_);
  return std::min(common_due, next_status_);
}

void SlaveGateway::end() {
  const SteadyTime now = steady_clock::now();
  while (take_reports(now)) {
  }  // the realtime thread has ended: the ring grows no more
  take_actions();
  take_jobs();
  take_done(now);
  posted_.publish(events_, now);
  (void)publish_status(now);
  commands_.stop_and_deliver(signal_, [this] { return context(steady_clock::now()); });
}

}  // namespace cansyncd
