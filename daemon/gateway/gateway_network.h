#pragma once

#include <chrono>
#include <string>

#include "daemon/desk/gateway_events.h"
#include "daemon/service/surroundings.h"
#include "daemon/status/common_status.h"
#include "dds/participant.h"

namespace cansyncd {

/// Takes the DDS side of a bus to where it is to be, and says so: events, and members of GatewayStatus. Its jobs
/// and all that is known of the line stay; to clients it is a daemon that has left and come, and writers of
/// before are lost. Gateway thread only.
class GatewayNetwork {
 public:
  /// DDS is not moved again for so long: an interface that comes and goes does not keep the gateway busy.
  static constexpr std::chrono::seconds kMoveAgain{5};

  /// All must outlive the object.
  GatewayNetwork(const gateway::dds::Participant& participant, EventPublisher& events, CommonStatus& status)
      : participant_(participant), events_(events), status_(status) {}

  /// Where DDS is to be from now on.
  void set(const NetworkPlace& place, SteadyTime now);

  /// It is elsewhere, and it is time to move.
  bool due(SteadyTime now) const;

  /// Moves. What was not taken from readers is lost.
  void move(SteadyTime now);

 private:
  bool is_there() const;
  void tell(const std::string& reason, SteadyTime now);

  const gateway::dds::Participant& participant_;
  EventPublisher& events_;
  CommonStatus& status_;
  NetworkPlace place_;
  std::string told_;  ///< why it is not where it is to be; empty: it is
  SteadyTime move_at_;
  bool failed_ = false;  ///< the last move
};

}  // namespace cansyncd
