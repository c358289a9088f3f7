#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync_slave.h"
#include "cansync_slave/config/config.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/gateway/action_reports.h"
#include "daemon/cansync_slave/gateway/application_gate.h"
#include "daemon/cansync_slave/gateway/job_samples.h"
#include "daemon/cansync_slave/gateway/release_gate.h"
#include "daemon/cansync_slave/gateway/slave_requests.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/job_desk.h"
#include "daemon/desk/ownership.h"
#include "daemon/gateway/gateway_base.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "dds/endpoint.h"
#include "dds/guard/writer_guid.h"
#include "dds/participant.h"

namespace cansyncd {

/// The gateway of a slave. While it runs, access and the greatest age of requests can change.
class SlaveGateway final : public GatewayBase<SlaveRoleConfig, SlaveExchange> {
 public:
  /// Time between two samples of SlaveSideStatus of which only counters differ.
  static constexpr std::chrono::seconds kStatusPeriod{1};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  SlaveGateway(const SlaveRoleConfig& config, SlaveExchange& exchange,
               const gateway::dds::Participant& participant, JournalSink& journal = process_journal(),
               const DaemonIdentity& identity = random_daemon_identity());

  /// Stops.
  ~SlaveGateway();

  /// As that of the base; who listens to whom, and how, is told first.
  void start();

 private:
  SteadyTime pass(bool samples_may_wait) override;
  void end() override;
  std::string metrics_text(std::uint64_t write_failures) const override;

  /// True: there may be more.
  bool take_reports(SteadyTime now);
  void publish(const SlaveSideReport& report, SteadyTime now);
  void publish_monitored(cansync::SlaveNumber slave, const cansync_slave::ReceivedValues& values);
  void take_actions();
  void take_jobs();
  SlaveContext context(SteadyTime now) const;
  /// Tells first what a command has changed, then its reply.
  void take_done(SteadyTime now);
  void take_over(const SlaveOrder& order);
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);

  const DaemonIdentity identity_;
  ReleaseGate releases_;
  ApplicationGate application_;
  ActionReports action_reports_;
  JobDesk<SlaveRequests> commands_;
  gateway::dds::Writer<cansync_slave_ReferencesReceived> references_;
  gateway::dds::Writer<cansync_slave_MonitoredValues> monitored_;
  gateway::dds::Writer<cansync_slave_ActionReceived> actions_;
  gateway::dds::Writer<cansync_slave_ParameterJob> parameter_jobs_;
  gateway::dds::Writer<cansync_slave_BlockJob> block_jobs_;
  gateway::dds::Writer<cansync_slave_SlaveSideStatus> status_;

  SlaveSnapshot snapshot_;  ///< newest
  OwnershipChanges ownership_;
  JobApplications job_applications_;
  JobApplications block_applications_;  ///< blocks have numbers of their own
  SteadyTime next_status_;
  cansync_slave_SlaveSideStatus told_status_ = {};  ///< newest
};

}  // namespace cansyncd
