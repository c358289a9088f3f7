#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/desk/job_desk.h"
#include "daemon/desk/ownership.h"
#include "daemon/gateway/gateway_base.h"
#include "daemon/gateway/loss_row.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/image_gate.h"
#include "daemon/layer2/gateway/run_lead_gate.h"
#include "daemon/layer2/gateway/send_requests.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "layer2.h"
#include "layer2/config/config.h"
#include "layer2/config/file.h"
#include "layer2/config/running.h"

namespace cansyncd {

/// The gateway of a bus of general frames. While it runs, access and the greatest age of requests can change.
///
/// Every request of a client gets exactly one reply; those open when the gateway stops are answered with
/// REPLY_MASTER_STOPPED.
class FrameGateway final : public GatewayBase<Layer2Config, Layer2Exchange> {
 public:
  /// Time between two samples of FrameStatus.
  static constexpr std::chrono::seconds kStatusPeriod{1};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  FrameGateway(const Layer2File& file, Layer2Exchange& exchange, const gateway::dds::Participant& participant,
               JournalSink& journal = process_journal(),
               const DaemonIdentity& identity = random_daemon_identity());

  /// Stops.
  ~FrameGateway();

 private:
  SteadyTime pass(bool samples_may_wait) override;
  void end() override;
  std::string metrics_text(std::uint64_t write_failures) const override;

  /// How the bus is, for `systemctl status`.
  std::string state_text() const;
  void take_answers(const SendContext& context);
  /// True: there may be more.
  bool publish_frames();
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);
  layer2_FrameStatus frame_status() const;
  void publish_timers(bool all);
  void forget_timer(unsigned number);
  void publish_image(SteadyTime now);
  void publish_objects();
  void publish_events();
  SendContext context(SteadyTime now);
  void set_rules(SteadyTime now);
  void take_running(SteadyTime time);
  void take_table(SteadyTime time);

  RunningConfiguration running_;
  JobDesk<SendRequests> jobs_;
  ImageGate image_gate_;
  RunLeadGate lead_;
  gateway::dds::Writer<layer2_FrameBatch> batches_;
  gateway::dds::Writer<layer2_FrameStatus> status_;
  gateway::dds::Writer<layer2_TimerStatus> timers_;
  gateway::dds::Writer<layer2_ProcessImage> image_;
  gateway::dds::Writer<layer2_ObjectStatus> objects_;
  gateway::dds::Writer<layer2_ModuleEvent> module_events_;

  std::vector<layer2_ReceivedFrame> batch_;  ///< memory of one batch
  std::uint64_t batch_number_ = 0;
  std::uint64_t unwritten_ = 0;  ///< frames of batches that could not be written
  std::uint64_t published_ = 0;  ///< frames in batches that were written
  BusSnapshot bus_;              ///< newest
  std::array<TimerState, layer2::Timers::kMost> told_timers_ = {};
  ImageSnapshot newest_image_;
  bool image_told_ = false;  ///< since there was none
  ObjectsSnapshot told_objects_;
  SteadyTime next_image_;
  std::uint64_t told_changes_ = 0;  ///< of `running_`, in force here
  LossRow losses_{not_published("frames")};
  LossRow left_out_;
  SteadyTime next_status_;
  layer2_FrameStatus told_status_ = {};  ///< newest
  OwnershipChanges ownership_;
};

}  // namespace cansyncd
