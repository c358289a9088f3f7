#pragma once

#include <optional>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/failsafe_commands.h"
#include "daemon/cansync/gateway/gateway_references.h"
#include "daemon/cansync/requests/protocol.h"
#include "daemon/cansync/requests/request_audit.h"
#include "daemon/cansync/status/gateway_state.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/job_desk.h"
#include "daemon/gateway/gateway_base.h"
#include "daemon/service/daemon_identity.h"
#include "dds/participant.h"

namespace cansyncd {

/// The gateway of a line with its master. While it runs, names, units and scaling, mappings, polling, cursors
/// and the greatest age of reference values can change. Only what differs from the configuration before is
/// changed on the line, so that what clients have set meanwhile stays.
///
/// Every request of a client gets exactly one terminal reply; all those open when the gateway stops are
/// answered with REPLY_MASTER_STOPPED.
class Gateway final : public GatewayBase<Config, Exchange> {
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

 private:
  SteadyTime pass(bool samples_may_wait) override;
  void end() override;
  std::string metrics_text(std::uint64_t write_failures) const override;

  void take_reports(const JobContext& context);
  void take_event(const Report& report, SteadyTime now);
  /// Tells when the row of skipped SYNC edges is over. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> tell_syncs(SteadyTime now);
  void take_configuration(SteadyTime now);
  JobContext context(SteadyTime now);

  StatePublisher state_;
  RequestAudit audit_;
  FailsafeCommands failsafe_;
  ReferenceInput references_;
  JobDesk<CansyncRequests> jobs_;
  FaultRow missed_syncs_{kSyncQuiet};
};

}  // namespace cansyncd
