#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "daemon/desk/gateway_events.h"
#include "daemon/j1939/exchange.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "j1939.h"
#include "j1939/dds/topics.h"

namespace cansyncd {

/// What other nodes tell of their faults: publishes FaultList when a diagnostic message says something new,
/// and an event for each active fault that appears or goes. Bounded: one list of at most 1785 bytes for each
/// address and kind. Gateway thread only.
class FaultBoard {
 public:
  /// A list that is heard unchanged is published again so often, for its time.
  static constexpr std::chrono::seconds kAgain{10};

  /// Throws gateway::dds::SetupError.
  FaultBoard(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
             EventPublisher& events)
      : events_(events), writer_(participant, 0, &signal) {}

  /// A message was received; others than DM1 and DM2 are not looked at.
  void take(const j1939_ReceivedMessage& message, SteadyTime now);

 private:
  struct Told {
    std::vector<std::uint8_t> message;
    std::optional<SteadyTime> published;
  };

  void tell_changes(const Told& before, const j1939_ReceivedMessage& message, SteadyTime now);

  EventPublisher& events_;
  gateway::dds::Writer<j1939_FaultList> writer_;
  std::array<std::array<Told, 2>, 254> told_;  ///< by address; previous and active faults
  std::vector<j1939_TroubleCode> memory_;
};

}  // namespace cansyncd
