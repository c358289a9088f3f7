#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "cansync_slave.h"
#include "daemon/cansync_slave/config/config.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/gateway/application_gate.h"
#include "daemon/cansync_slave/gateway/release_gate.h"
#include "daemon/cansync_slave/gateway/slave_requests.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_thread.h"
#include "daemon/desk/job_desk.h"
#include "daemon/desk/second_daemon.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "daemon/service/new_configuration.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Binds the exchange with the realtime thread of a slave to the DDS topics: one thread of normal priority
/// that sleeps until the realtime thread or DDS has something, and the only one that touches DDS.
class SlaveGateway {
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
  SlaveGateway(const SlaveGateway&) = delete;
  SlaveGateway& operator=(const SlaveGateway&) = delete;

  /// What the realtime thread asked for and was granted, for RealtimeStatus. Before `start`.
  void set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
    common_.set_realtime(wanted, granted);
  }

  /// Starts the thread; once. Throws std::system_error when there is no thread to be had.
  void start();

  /// Ends the thread; what the realtime thread has left in the exchange is still told. Further calls do
  /// nothing.
  void stop() noexcept;

  /// Passes over everything that may have come, so far: stands still for longer than a second only when the
  /// thread does. Any thread.
  std::uint64_t passes() const noexcept { return thread_.passes(); }

  /// Publishes an event of another thread. Any thread; returns at once. More than `PostedEvents::kMost`
  /// that wait are lost.
  void post(const EventText& event);

  /// Takes over what can change while running: access. Any thread; returns at once.
  void reload(const SlaveRoleConfig& config);

 private:
  /// Returns when the next pass is due at the latest. The readers are asked only when `samples_may_wait`.
  SteadyTime pass(bool samples_may_wait);
  void take_configuration(SteadyTime now);
  /// True: there may be more.
  bool take_reports(SteadyTime now);
  void publish(const SlaveSideReport& report, SteadyTime now);
  void publish_monitored(cansync::SlaveNumber slave, const cansync_slave::ReceivedValues& values);
  void take_jobs();
  SlaveContext context(SteadyTime now) const;
  /// Tells first what a command has changed, then its reply.
  void take_done(SteadyTime now);
  void take_over(const SlaveOrder& order);
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);
  void end();

  SlaveRoleConfig config_;  ///< gateway thread only, once it runs
  SlaveExchange& exchange_;
  gateway::dds::DataSignal signal_;  ///< before everything that raises it
  EventPublisher events_;
  CommonStatus common_;
  SecondDaemon second_daemon_;
  const DaemonIdentity identity_;
  ReleaseGate releases_;
  ApplicationGate application_;
  AuditTrail trail_;
  JobDesk<SlaveRequests> commands_;
  gateway::dds::Writer<cansync_slave_ReferencesReceived> references_;
  gateway::dds::Writer<cansync_slave_MonitoredValues> monitored_;
  gateway::dds::Writer<cansync_slave_ActionReceived> actions_;
  gateway::dds::Writer<cansync_slave_ParameterJob> parameter_jobs_;
  gateway::dds::Writer<cansync_slave_BlockJob> block_jobs_;
  gateway::dds::Writer<cansync_slave_SlaveSideStatus> status_;

  SlaveSnapshot snapshot_;  ///< newest
  std::uint64_t action_number_ = 0;
  std::string told_application_;  ///< of the newest status
  SteadyTime next_status_;
  cansync_slave_SlaveSideStatus told_status_ = {};  ///< newest
  std::optional<MetricsDesk> metrics_;              ///< from `start` to `stop`

  NewConfiguration<SlaveRoleConfig> new_configuration_;
  PostedEvents posted_;
  GatewayThread thread_;  ///< last: it uses all of them
};

}  // namespace cansyncd
