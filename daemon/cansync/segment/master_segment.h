#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/bus/bus_choice.h"
#include "daemon/cansync/config/file.h"
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
  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error (of the SYNC
  /// line), std::system_error or gateway::dds::SetupError for what cannot be had.
  /// `changed`: options for which the line is set up anew; told as an event. Empty: the daemon starts.
  MasterSegment(ConfigFile file, JournalSink& journal, gateway::dds::Participant participant,
                std::vector<std::string> changed = {});
  ~MasterSegment() override;
  MasterSegment(const MasterSegment&) = delete;
  MasterSegment& operator=(const MasterSegment&) = delete;

  void start() override;
  void stop() noexcept override;
  bool stop_unless_active() noexcept override;
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;
  void tell_reload(const ReloadPlan& plan) override;

 private:
  ConfigFile file_;
  std::vector<std::string> changed_;
  const ServiceLog log_;
  BusChoice bus_;
  std::unique_ptr<SyncLine> sync_line_;
  Exchange exchange_;
  gateway::dds::Participant participant_;
  Gateway gateway_;
  FlightDesk flight_;
  RealtimeLoop loop_;
  SegmentThreads<RealtimeLoop, Gateway, Exchange> threads_;
};

}  // namespace cansyncd
