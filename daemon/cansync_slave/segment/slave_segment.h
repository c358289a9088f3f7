#pragma once

#include <memory>
#include <span>
#include <string>

#include "daemon/bus/bus_choice.h"
#include "daemon/cansync_slave/config/file.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/gateway/slave_gateway.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "daemon/loop/deadline_loop.h"
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
SlaveRoleFile load_slave_checked(const std::string& path, std::span<const std::string> overrides);

/// The bus of a configuration, with the simulated master. Main thread.
BusPlan slave_bus_plan(const SlaveRoleConfig& config);

/// What the realtime thread needs of a configuration; `line` and `wire` may be null.
SlaveMachineSettings slave_machine_settings(const SlaveRoleConfig& config, FlightTap* tap,
                                            const SyncFollower::Inputs& inputs);

/// A slave on one bus: everything that runs, in the order it is built; taken down the other way round.
class SlaveSegment final : public Segment {
 public:
  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error, std::system_error
  /// or gateway::dds::SetupError for what cannot be had.
  SlaveSegment(SlaveRoleFile file, JournalSink& journal, gateway::dds::Participant participant);
  ~SlaveSegment() override;
  SlaveSegment(const SlaveSegment&) = delete;
  SlaveSegment& operator=(const SlaveSegment&) = delete;

  /// Throws rt::RealtimeError when realtime is enforced and not granted, std::system_error without threads.
  void start() override;
  void stop() noexcept override;
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;

 private:
  SlaveRoleFile file_;
  const ServiceLog log_;
  BusChoice bus_;
  std::unique_ptr<SyncLine> sync_line_;  ///< null on a simulated bus, and without an input
  SlaveExchange exchange_;
  gateway::dds::Participant participant_;
  SlaveGateway gateway_;
  FlightDesk flight_;
  SlaveMachine machine_;
  DeadlineLoop<SlaveMachine> loop_;
  SegmentThreads<DeadlineLoop<SlaveMachine>, SegmentSide<SlaveGateway, SlaveExchange>> threads_;
};

}  // namespace cansyncd
