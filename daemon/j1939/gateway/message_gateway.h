#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/job_desk.h"
#include "daemon/gateway/gateway_base.h"
#include "daemon/gateway/loss_row.h"
#include "daemon/j1939/exchange.h"
#include "daemon/j1939/gateway/fault_board.h"
#include "daemon/j1939/gateway/message_requests.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "j1939.h"
#include "j1939/config/config.h"

namespace cansyncd {

/// The gateway of a bus of J1939. While it runs, access and the greatest age of requests can change.
///
/// Every request of a client gets exactly one reply; those open when the gateway stops are answered with
/// REPLY_MASTER_STOPPED.
class MessageGateway final : public GatewayBase<J1939Config, J1939Exchange> {
 public:
  /// Time between two samples of NodeStatus.
  static constexpr std::chrono::seconds kStatusPeriod{1};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  MessageGateway(const J1939Config& config, J1939Exchange& exchange,
                 const gateway::dds::Participant& participant, JournalSink& journal = process_journal(),
                 const DaemonIdentity& identity = random_daemon_identity());

  /// Stops.
  ~MessageGateway();

 private:
  SteadyTime pass(bool samples_may_wait) override;
  void end() override;
  std::string metrics_text(std::uint64_t write_failures) const override;

  /// How the node is, for `systemctl status`.
  std::string state_text() const;
  void take_answers(const MessageContext& context);
  /// True: there may be more.
  bool publish_messages();
  /// Takes reports until a batch is full; false: there are no more.
  bool collect_batch();
  void publish_batch();
  void publish_long(const MessageReport& report);
  void publish_addresses();
  void tell_claim(const NodeSnapshot& before, SteadyTime now);
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);
  j1939_NodeStatus node_status() const;
  MessageContext context(SteadyTime now) const;

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
  LossRow losses_{not_published("messages")};
  LossRow left_out_;
  SteadyTime next_status_;
  j1939_NodeStatus told_status_ = {};  ///< newest
};

}  // namespace cansyncd
