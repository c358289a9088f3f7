#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cansync/config/file.h"
#include "daemon/bus/bus_choice.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/gateway/gateway.h"
#include "daemon/cansync/realtime/realtime_loop.h"
#include "daemon/loop/sync_line.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/segment.h"
#include "daemon/segment/segment_start.h"
#include "daemon/segment/segment_threads.h"
#include "daemon/service/journal.h"
#include "daemon/service/service_log.h"
#include "dds/participant.h"

namespace cansyncd {

/// The master of a CANsync line: everything that runs, in the order it is built; taken down the other way
/// round.
class MasterSegment final : public Segment {
 public:
  /// What a segment takes over from the one before, when a line is set up anew.
  struct Before {
    std::vector<std::string> changed;   ///< options that have changed; told as an event
    std::optional<StartTarget> target;  ///< where the line was going: one that was stopped stays so
  };

  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error (of the SYNC
  /// line), std::system_error or gateway::dds::SetupError for what cannot be had.
  /// `before`: whose place it takes; nothing: the daemon starts.
  MasterSegment(ConfigFile file, JournalSink& journal, gateway::dds::Participant participant,
                Before before = {});
  ~MasterSegment() override;
  MasterSegment(const MasterSegment&) = delete;
  MasterSegment& operator=(const MasterSegment&) = delete;

  void start() override;
  void end_realtime() noexcept override { threads_.end_realtime(); }
  void stop() noexcept override;
  bool stop_unless_active() noexcept override;
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;
  void post(const EventText& event) override { gateway_.post(event); }
  void set_surroundings(const Surroundings& surroundings) override {
    gateway_.set_surroundings(surroundings);
  }
  bool in_run() const noexcept override { return gateway_.in_run(); }
  void set_pending_restart(const PendingRestart& pending) override { gateway_.set_pending_restart(pending); }

 private:
  ConfigFile file_;
  Before before_;
  /// Where the line was going when it was stopped for another segment, which may outlive this one.
  std::shared_ptr<StartTarget> target_at_stop_ = std::make_shared<StartTarget>(StartTarget::none);
  const ServiceLog log_;
  BusChoice bus_;
  std::unique_ptr<SyncLine> sync_line_;
  Exchange exchange_;
  gateway::dds::Participant participant_;
  Gateway gateway_;
  FlightDesk flight_;
  RealtimeLoop loop_;
  SegmentThreads<RealtimeLoop, SegmentSide<Gateway, Exchange>> threads_;
};

}  // namespace cansyncd
