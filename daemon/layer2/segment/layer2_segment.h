#pragma once

#include <span>
#include <string>

#include "daemon/bus/bus_choice.h"
#include "daemon/layer2/config/file.h"
#include "daemon/layer2/exchange.h"
#include "daemon/layer2/gateway/frame_gateway.h"
#include "daemon/layer2/realtime/frame_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/recorder/flight_desk.h"
#include "daemon/segment/segment.h"
#include "daemon/segment/segment_start.h"
#include "daemon/segment/segment_threads.h"
#include "daemon/service/journal.h"
#include "daemon/service/service_log.h"
#include "dds/participant.h"

namespace cansyncd {

/// Reads and checks a configuration completely: the file, and what stands behind it. Main thread.
Layer2File load_layer2_checked(const std::string& path, std::span<const std::string> overrides);

/// The bus of a configuration, with its simulated nodes. Main thread.
BusPlan layer2_bus_plan(const Layer2Config& config);

/// What the realtime thread needs of a configuration.
FrameMachineSettings frame_machine_settings(const Layer2Config& config, FlightTap* tap);

/// General frames on one bus: everything that runs, in the order it is built; taken down the other way round.
class Layer2Segment final : public Segment {
 public:
  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error, std::system_error
  /// or gateway::dds::SetupError for what cannot be had.
  Layer2Segment(Layer2File file, JournalSink& journal, gateway::dds::Participant participant);
  ~Layer2Segment() override;
  Layer2Segment(const Layer2Segment&) = delete;
  Layer2Segment& operator=(const Layer2Segment&) = delete;

  void start() override;
  void stop() noexcept override;
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;
  void tell_reload(const ReloadPlan& plan) override;

 private:
  Layer2File file_;
  const ServiceLog log_;
  BusChoice bus_;
  Layer2Exchange exchange_;
  gateway::dds::Participant participant_;
  FrameGateway gateway_;
  FlightDesk flight_;
  FrameMachine machine_;
  DeadlineLoop<FrameMachine> loop_;
  SegmentThreads<DeadlineLoop<FrameMachine>, SegmentSide<FrameGateway, Layer2Exchange>> threads_;
};

}  // namespace cansyncd
