#pragma once

#include <array>
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
#include "daemon/layer2/config/config.h"
#include "daemon/layer2/config/file.h"
#include "daemon/layer2/config/running.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/image_gate.h"
#include "daemon/layer2/gateway/run_lead_gate.h"
#include "daemon/layer2/gateway/send_requests.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/journal.h"
#include "daemon/service/new_configuration.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_desk.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "dds/signal.h"
#include "layer2.h"

namespace cansyncd {

/// Binds the exchange with the realtime thread of a bus of general frames to the DDS topics: one thread of
/// normal priority that sleeps until the realtime thread or DDS has something, and the only one that touches
/// DDS.
///
/// Every request of a client gets exactly one reply; those open when the gateway stops are answered with
/// REPLY_MASTER_STOPPED.
class FrameGateway {
 public:
  /// Losing frames again and again is one row until none was lost for so long.
  static constexpr std::chrono::seconds kLossQuiet{3};
  /// Time between two samples of FrameStatus.
  static constexpr std::chrono::seconds kStatusPeriod{1};

  /// Sets up every topic; nothing is taken or published before `start`. `exchange`, `participant` and
  /// `journal` must outlive the gateway. `identity`: of this start. Throws gateway::dds::SetupError.
  FrameGateway(const Layer2File& file, Layer2Exchange& exchange, const gateway::dds::Participant& participant,
               JournalSink& journal = process_journal(),
               const DaemonIdentity& identity = random_daemon_identity());

  /// Stops.
  ~FrameGateway();
  FrameGateway(const FrameGateway&) = delete;
  FrameGateway& operator=(const FrameGateway&) = delete;

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
  void reload(const Layer2Config& config);

 private:
  /// Returns when the next pass is due at the latest. The readers are asked only when `samples_may_wait`.
  SteadyTime pass(bool samples_may_wait);
  void take_configuration(SteadyTime now);
  void take_answers(const SendContext& context);
  /// True: there may be more.
  bool publish_frames();
  void tell_losses(SteadyTime now);
  void tell_bus(const can::ControllerStatus& before, SteadyTime now);
  /// Returns when to call again.
  SteadyTime publish_status(SteadyTime now);
  layer2_FrameStatus frame_status() const;
  void publish_timers(bool all);
  void forget_timer(unsigned number);
  void publish_image(SteadyTime now);
  void publish_objects();
  void publish_events();
  void end_jobs();
  SendContext context(SteadyTime now);
  void set_rules();
  void take_running();

  RunningConfiguration running_;
  Layer2Config config_;  ///< gateway thread only, once it runs
  Layer2Exchange& exchange_;
  gateway::dds::DataSignal signal_;  ///< before everything that raises it
  EventPublisher events_;
  CommonStatus common_;
  SecondDaemon second_daemon_;
  AuditTrail trail_;
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
  ObjectsSnapshot told_objects_;
  SteadyTime next_image_;
  std::uint64_t told_lost_ = 0;
  std::uint64_t told_changes_ = 0;  ///< of `running_`, in force here
  FaultRow losses_{kLossQuiet};
  SteadyTime next_status_;
  layer2_FrameStatus told_status_ = {};  ///< newest
  std::optional<MetricsDesk> metrics_;   ///< from `start` to `stop`

  NewConfiguration<Layer2Config> new_configuration_;
  PostedEvents posted_;
  GatewayThread thread_;  ///< last: it uses all of them
};

}  // namespace cansyncd
