#include "daemon/gateway/gateway_network.h"

#include <optional>

namespace cansyncd {

void GatewayNetwork::set(const NetworkPlace& place, SteadyTime now) {
  place_ = place;
  if (is_there() && place_.reason != told_) tell(place_.reason, now);
}

bool GatewayNetwork::is_there() const {
  const auto& here = participant_.options();
  return place_.interface.empty() ||
         (!failed_ && place_.interface == here.interface && place_.link == here.link);
}

bool GatewayNetwork::due(SteadyTime now) const {
  return !is_there() && now >= move_at_;
}

void GatewayNetwork::move(SteadyTime now) {
  move_at_ = now + kMoveAgain;
  std::string reason = place_.reason;
  try {
    participant_.move_to(place_.interface, place_.link);
    failed_ = false;
  } catch (const gateway::dds::SetupError& error) {
    failed_ = true;
    reason = error.what();
  }
  // Another address is told, a move that fails again is not.
  if (reason.empty() || reason != told_) tell(reason, now);
}

void GatewayNetwork::tell(const std::string& reason, SteadyTime now) {
  told_ = reason;
  status_.set_network(participant_.options(), reason);
  if (!reason.empty()) {
    events_.publish({gateway_SEVERITY_WARNING, "network_lost", -1, reason, std::nullopt}, now);
  } else {
    events_.publish({gateway_SEVERITY_INFO, "network_joined", -1,
                     "clients of the network are served: " + participant_.place(), std::nullopt},
                    now);
  }
}

}  // namespace cansyncd
