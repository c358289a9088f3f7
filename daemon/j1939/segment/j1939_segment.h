#pragma once

#include <span>
#include <string>

#include "daemon/bus/bus_choice.h"
#include "daemon/j1939/config/file.h"
#include "daemon/j1939/exchange.h"
#include "daemon/j1939/gateway/message_gateway.h"
#include "daemon/j1939/realtime/message_machine.h"
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
J1939File load_j1939_checked(const std::string& path, std::span<const std::string> overrides);

/// The address and the NAME of a configuration, for people.
std::string address_text(const J1939Config& config);

/// The bus of a configuration, with its simulated nodes. Main thread.
BusPlan j1939_bus_plan(const J1939Config& config);

/// What the realtime thread needs of a configuration.
MessageMachineSettings message_machine_settings(const J1939Config& config, FlightTap* tap);

/// J1939 on one bus: everything that runs, in the order it is built; taken down the other way round.
class J1939Segment final : public Segment {
 public:
  /// `file` has no problems; `journal` must outlive the segment. Throws std::runtime_error, std::system_error
  /// or gateway::dds::SetupError for what cannot be had.
  J1939Segment(J1939File file, JournalSink& journal, gateway::dds::Participant participant);
  ~J1939Segment() override;
  J1939Segment(const J1939Segment&) = delete;
  J1939Segment& operator=(const J1939Segment&) = delete;

  void start() override;
  void stop() noexcept override;
  Heartbeat::Progress progress() const noexcept override { return {loop_.wake_ups(), gateway_.passes()}; }
  bool record() noexcept override { return flight_.request(); }
  ReloadPlan plan_reload(std::span<const std::string> overrides) override;
  void tell_reload(const ReloadPlan& plan) override;

 private:
  J1939File file_;
  const ServiceLog log_;
  BusChoice bus_;
  J1939Exchange exchange_;
  gateway::dds::Participant participant_;
  MessageGateway gateway_;
  FlightDesk flight_;
  MessageMachine machine_;
  DeadlineLoop<MessageMachine> loop_;
  SegmentThreads<DeadlineLoop<MessageMachine>, SegmentSide<MessageGateway, J1939Exchange>> threads_;
};

}  // namespace cansyncd
