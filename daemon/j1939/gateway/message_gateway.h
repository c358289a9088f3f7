#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "daemon/desk/audit.h"
#include "daemon/desk/event_text.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/gateway_thread.h"
#include "daemon/desk/job_desk.h"
#include "daemon/desk/second_daemon.h"
#include "daemon/j1939/config/config.h"
#include "daemon/j1939/exchange.h"
#include "daemon/j1939/gateway/fault_board.h"
#include "daemon/j1939/gateway/message_requests.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "daemon/service/new_configuration.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "j1939.h"

namespace cansyncd {

/// Binds the exchange with the realtime thread of a bus of J1939 to the DDS topics: one thread of
/// normal priority that sleeps until the realtime thread or DDS has something, and the only one that touches
/// DDS.
///
/// Every request of a client gets exactly one reply; those open when the gateway stops are answered with
/// REPLY_MASTER_STOPPED.
class MessageGateway {
 public:
  /// Losing messages again and again is one row until none was lost for so long.
  static constexpr std::chrono::seconds kLossQuiet{3};
  /// Time between two samples of NodeStatus.
  static constexpr std::chrono::seconds kStatusPeriod{1};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  MessageGateway(const J1939Config& config, J1939Exchange& exchange,
                 const gateway::dds::Participant& participant, JournalSink& journal = process_journal(),
                 const DaemonIdentity& identity = random_daemon_identity());

  /// Stops.
  ~MessageGateway();
  MessageGateway(const MessageGateway&) = delete;
  MessageGateway& operator=(const MessageGateway&) = delete;

  /// What the realtime thread asked for and was granted, for RealtimeStatus. Before `start`.
  void set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) {
    common_.set_realtime(wanted, granted);
  }

  /// Starts the thread; once. Throws std::system_error when there is no thread to be had.
  void start();

  /// Answers every open request, waits a little until the clients have the replies, and ends the thread. What
  /// the realtime thread has left in the exchange is still told. Further calls do nothing.
  void stop() noexcept;

  /// Passes over everything that may have come, so far: stands still for longer than a second only when the
  /// thread does. Any thread.
  std::uint64_t passes() const noexcept { return thread_.passes(); }

  /// Publishes an event of another thread. Any thread; returns at once. More than `PostedEvents::kMost`
  /// that wait are lost.
  void post(const EventText& event);

  /// Takes over what can change while running: access, greatest age of requests. Any thread; returns at once.
  void reload(const J1939Config& config);

 private:
  /// Returns when the next pass is due at the latest. The readers are asked only when `samples_may_wait`.
  SteadyTime pass(bool samples_may_wait);
  void take_configuration(SteadyTime now);
  void take_answers(const MessageContext& context);
  /// True: there may be more.
  bool publish_messages();
  /// Takes reports until a batch is full; false: there are no more.
  bool collect_batch();
  void publish_batch();
  void publish_long(const MessageReport& report);
  void publish_addresses();
  void tell_losses(SteadyTime now);
  void tell_claim(const NodeSnapshot& before, SteadyTime now);
  void tell_bus(const can::ControllerStatus& before, SteadyTime now);
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);
  j1939_NodeStatus node_status() const;
  void end_jobs();
  MessageContext context(SteadyTime now) const;

  J1939Config config_;  ///< gateway thread only, once it runs
  J1939Exchange& exchange_;
  gateway::dds::DataSignal signal_;  ///< before everything that raises it
  EventPublisher events_;
  CommonStatus common_;
  SecondDaemon second_daemon_;
  AuditTrail trail_;
  JobDesk<MessageRequests> jobs_;
  gateway::dds::Writer<j1939_MessageBatch> batches_;
  gateway::dds::Writer<j1939_LongMessage> long_messages_;
  gateway::dds::Writer<j1939_NodeStatus> status_;

  gateway::dds::Writer<j1939_AddressTable> tables_;
  FaultBoard faults_;

  std::vector<j1939_ReceivedMessage> batch_;  ///< memory of one batch
  std::vector<MessageReport> reports_;        ///< to whose short data it points
  std::vector<LongData> long_data_;           ///< and to these
  std::vector<j1939_ClaimedAddress> addresses_;
  std::vector<std::uint8_t> longest_;  ///< memory of one LongMessage
  std::uint64_t long_number_ = 0;
  std::uint64_t batch_number_ = 0;
  std::uint64_t unwritten_ = 0;  ///< messages of batches that could not be written
  NodeSnapshot bus_;             ///< newest
  std::uint64_t told_lost_ = 0;
  FaultRow losses_{kLossQuiet};
  SteadyTime next_status_;
  j1939_NodeStatus told_status_ = {};   ///< newest
  std::optional<MetricsDesk> metrics_;  ///< from `start` to `stop`

  NewConfiguration<J1939Config> new_configuration_;
  PostedEvents posted_;
  GatewayThread thread_;  ///< last: it uses all of them
};

}  // namespace cansyncd
