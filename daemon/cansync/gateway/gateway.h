#pragma once

#include <optional>

#include "daemon/cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/failsafe_commands.h"
#include "daemon/cansync/gateway/gateway_references.h"
#include "daemon/cansync/requests/protocol.h"
#include "daemon/cansync/requests/request_audit.h"
#include "daemon/cansync/status/gateway_state.h"
#include "daemon/cansync/status/status_line.h"
#include "daemon/desk/audit.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_thread.h"
#include "daemon/desk/job_desk.h"
#include "daemon/desk/second_daemon.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/new_configuration.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Binds the exchange with the realtime thread to the DDS topics: one thread of normal priority that sleeps
/// until the realtime thread or DDS has something, and the only one that touches DDS.
///
/// Every request of a client gets exactly one terminal reply; all those open when the gateway stops are
/// answered with REPLY_MASTER_STOPPED.
class Gateway {
 public:
  /// SYNC edges that are skipped again and again are one row until none was for so long.
  static constexpr std::chrono::seconds kSyncQuiet{10};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  Gateway(const Config& config, Exchange& exchange, const gateway::dds::Participant& participant,
          JournalSink& journal = process_journal(),
          const DaemonIdentity& identity = random_daemon_identity());

  /// Stops. The realtime thread must have ended before, because it may hold the data of transfers; a gateway
  /// that was only stopped still keeps it.
  ~Gateway();
  Gateway(const Gateway&) = delete;
  Gateway& operator=(const Gateway&) = delete;

  /// What the realtime thread asked for and was granted, for RealtimeStatus. Before `start`.
  void set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
    common_.set_realtime(wanted, granted);
  }

  /// Starts the thread; once. Throws std::system_error when there is no thread to be had.
  void start();

  /// Answers every open request, waits a little until the clients have the replies, and ends the thread.
  /// Whether the realtime thread has ended before does not matter; results it has left in the exchange are
  /// still told. Further calls do nothing.
  void stop() noexcept;

  /// Passes over everything that may have come, so far: stands still for longer than a second only when the
  /// thread does. Any thread.
  std::uint64_t passes() const noexcept { return thread_.passes(); }

  /// Publishes an event of another thread. Any thread; returns at once. More than `PostedEvents::kMost` that
  /// wait are lost.
  void post(const EventText& event);

  /// Takes over what can change while running: names, units and scaling, mappings, polling, cursors, greatest
  /// age of reference values. Only what differs from the configuration before is changed on the line, so that
  /// what clients have set meanwhile stays. Everything else in `config` is ignored. Any thread; returns at
  /// once.
  void reload(const Config& config);

 private:
  /// One pass over everything that may have come; returns when the next is due at the latest. The readers are
  /// asked only when `samples_may_wait`.
  SteadyTime pass(bool samples_may_wait);
  SteadyTime tell_common(SteadyTime now);
  void take_reports(const JobContext& context);
  void take_event(const Report& report, SteadyTime now);
  /// Tells when the row of skipped SYNC edges is over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tell_syncs(SteadyTime now);
  void take_configuration(SteadyTime now);
  void end_jobs();
  JobContext context(SteadyTime now);

  Config config_;  ///< gateway thread only, once it runs
  Exchange& exchange_;
  gateway::dds::DataSignal signal_;  ///< before everything that raises it
  EventPublisher events_;
  CommonStatus common_;
  SecondDaemon second_daemon_;
  StatePublisher state_;
  AuditTrail trail_;
  RequestAudit audit_;
  FailsafeCommands failsafe_;
  ReferenceInput references_;
  JobDesk<CansyncRequests> jobs_;
  FaultRow missed_syncs_{kSyncQuiet};
  StatusLine status_line_;
  std::optional<MetricsDesk> metrics_;  ///< from `start` to `stop`

  NewConfiguration<Config> new_configuration_;
  PostedEvents posted_;
  GatewayThread thread_;  ///< last: it uses all of them
};

}  // namespace cansyncd
