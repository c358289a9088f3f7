#pragma once

#include <string>

#include "daemon/desk/gateway_events.h"
#include "dds/daemon_identity.h"
#include "dds/other_daemons.h"
#include "dds/participant.h"
#include "dds/signal.h"

namespace cansyncd {

/// Tells when another daemon serves the same bus, and when it is gone: a network that is whole again, or a
/// start that `dds.name_in_use` allowed. Gateway thread only.
class SecondDaemon {
 public:
  /// `signal` is raised when there may be something to tell; it and `events` must outlive this object. `own`:
  /// this start. Throws gateway::dds::SetupError.
  SecondDaemon(const gateway::dds::Participant& participant, gateway::dds::DataSignal& signal,
               EventPublisher& events, std::string bus, const gateway::dds::DaemonIdentity& own);

  /// Tells what is new.
  void look(SteadyTime now);

 private:
  gateway::dds::OtherDaemons others_;
  EventPublisher& events_;
  const std::string bus_;
};

}  // namespace cansyncd
