#pragma once

#include <chrono>
#include <cstddef>
#include <string_view>

#include "daemon/config/daemon_config.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/rejections.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/status/incompatible_peers.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "gateway.h"

namespace cansyncd {

/// Publishes the status that is true of a bus whatever its protocol, on every change and once a second:
/// GatewayStatus; and tells of programs that do not match. Gateway thread only.
class CommonStatus {
 public:
  /// Each topic is told at least this often.
  static constexpr std::chrono::seconds kPeriod{1};

  /// `protocol`: as the option `bus.protocol` names it. Throws gateway::dds::SetupError.
  CommonStatus(const gateway::dds::Participant& participant, EventPublisher& events,
               const DaemonConfig& config, std::string_view protocol, const DaemonIdentity& identity);

  /// Who may do what from now on; told with the next `step`.
  void set_access(const AccessConfig& access) noexcept;

  /// How many clients there are, and what of them was rejected; counters wait for the next second.
  void set_clients(std::size_t clients, const RejectionCounts& rejections) noexcept;

  /// Publishes what is due. Returns when to call again at the latest.
  SteadyTime step(SteadyTime now);

 private:
  IncompatiblePeers peers_;
  gateway::dds::Writer<gateway_GatewayStatus> gateway_writer_;
  gateway_GatewayStatus gateway_ = {};
  bool dirty_ = true;
  SteadyTime published_;
};

}  // namespace cansyncd
