#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "cansync/cluster/cluster.h"
#include "cansync_cluster/config/file.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/gateway/slave_gateway.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/loop/beside_bus.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/leading_edges.h"
#include "daemon/loop/sync_line.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/segment.h"
#include "daemon/segment/segment_start.h"
#include "daemon/segment/segment_threads.h"
#include "daemon/service/journal.h"
#include "daemon/service/service_log.h"
#include "dds/participant.h"

namespace cansyncd {

/// Reads and checks a configuration completely: the file, and what stands behind it. Main thread.
ClusterFile load_cluster_checked(const config::Source& source, std::span<const std::string> overrides);

/// The realtime thread's work for both buses: the master's loop, which serves the slave's machine while it
/// sleeps.
class ClusterLoop {
 public:
  /// Both must outlive the object; `loop` drives `both`.
  ClusterLoop(BesideBus<SlaveMachine>& both, RealtimeLoop& loop) noexcept : both_(both), loop_(loop) {}

  /// Runs until `request_stop`: the slave begins first and ends last (O 7.1.2). Realtime thread.
  void run() noexcept {
    both_.begin();
    loop_.run();
    both_.end();
  }
  /// Any thread.
  void request_stop() noexcept { loop_.request_stop(); }
  /// Any thread.
  std::uint64_t wake_ups() const noexcept { return loop_.wake_ups(); }

 private:
  BesideBus<SlaveMachine>& both_;
  RealtimeLoop& loop_;
};

/// A slave of one bus that is the master of another: everything that runs, in the order it is built; taken
/// down the other way round.
class ClusterSegment final : public Segment {
 public:
  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error, std::system_error
  /// or gateway::dds::SetupError for what cannot be had.
  ClusterSegment(ClusterFile file, JournalSink& journal, gateway::dds::Participant upper,
                 gateway::dds::Participant lower);
  ~ClusterSegment() override;
  ClusterSegment(const ClusterSegment&) = delete;
  ClusterSegment& operator=(const ClusterSegment&) = delete;

  /// Throws rt::RealtimeError when realtime is enforced and not granted, std::system_error without threads.
  void start() override;
  void end_realtime() noexcept override { threads_.end_realtime(); }
  void stop() noexcept override;
  Heartbeat::Progress progress() const noexcept override;
  bool record() noexcept override;
  /// Every change needs a restart.
  void set_surroundings(const Surroundings& surroundings) override;
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;
  void post(const EventText& event) override {
    upper_gateway_.post(event);
    lower_gateway_.post(event);
  }
  bool in_run() const noexcept override { return upper_gateway_.in_run() || lower_gateway_.in_run(); }
  void set_pending_restart(const PendingRestart& pending) override {
    upper_gateway_.set_pending_restart(pending);
    lower_gateway_.set_pending_restart(pending);
  }

 private:
  ClusterFile file_;
  const ServiceLog upper_log_;
  const ServiceLog lower_log_;
  BusChoice upper_bus_;
  BusChoice lower_bus_;
  std::unique_ptr<SyncLine> upper_sync_;  ///< null on a simulated bus
  std::unique_ptr<SyncLine> lower_sync_;  ///< null without an output
  cansync::Cluster cluster_;
  LeadingEdges edges_;
  SlaveExchange upper_exchange_;
  Exchange lower_exchange_;
  gateway::dds::Participant upper_participant_;
  gateway::dds::Participant lower_participant_;
  SlaveGateway upper_gateway_;
  Gateway lower_gateway_;
  FlightDesk upper_flight_;
  SlaveMachine machine_;
  DeadlineLoop<SlaveMachine> upper_loop_;
  BesideBus<SlaveMachine> both_;
  FlightDesk lower_flight_;
  RealtimeLoop lower_loop_;
  ClusterLoop loop_;
  mutable Heartbeat::Progress passes_;  ///< of both gateways, when both had come further
  mutable std::uint64_t both_further_ = 0;
  SegmentThreads<ClusterLoop, SegmentSide<SlaveGateway, SlaveExchange>, SegmentSide<Gateway, Exchange>>
      threads_;
};

}  // namespace cansyncd
