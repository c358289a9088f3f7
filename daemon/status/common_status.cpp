#include "daemon/status/common_status.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>

#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

/// Of this computer; empty when the system does not tell.
std::string_view host_name(std::array<char, 256>& memory) noexcept {
  memory = {};
  if (gethostname(memory.data(), memory.size() - 1) != 0) return {};
  return memory.data();
}

/// What of GatewayStatus does not change while the daemon runs.
gateway_GatewayStatus lasting(const DaemonConfig& config, std::string_view protocol,
                              const DaemonIdentity& identity) {
  gateway_GatewayStatus status = {};
  std::array<char, 256> memory;
  gateway::dds::copy_text(config.bus.name, status.bus);
  status.data_model = gateway_DATA_MODEL;
  gateway::dds::copy_text(protocol, status.protocol);
  gateway::dds::copy_text(CANSYNC_VERSION, status.version);
  std::copy(identity.begin(), identity.end(), std::begin(status.daemon));
  gateway::dds::copy_text(host_name(memory), status.host);
  status.process = static_cast<std::uint32_t>(getpid());
  if (config.dds.xml.empty()) gateway::dds::copy_text(config.dds.interface, status.dds_interface);
  status.secured = !config.dds.security.empty();
  return status;
}

}  // namespace

CommonStatus::CommonStatus(const gateway::dds::Participant& participant, EventPublisher& events,
                           const DaemonConfig& config, std::string_view protocol,
                           const DaemonIdentity& identity)
    : peers_(participant, events),
      gateway_writer_(participant),
      gateway_(lasting(config, protocol, identity)) {
  set_access(config.access);
}

void CommonStatus::set_access(const AccessConfig& access) noexcept {
  gateway_.read_only = access.read_only;
  dirty_ = true;
}

void CommonStatus::set_clients(std::size_t clients, const RejectionCounts& rejections) noexcept {
  gateway_.clients = static_cast<std::uint32_t>(clients);
  const auto of = [&rejections](Rejection kind) { return rejections[static_cast<unsigned>(kind)]; };
  gateway_.rejected_values = of(Rejection::value);
  gateway_.rejected_full = of(Rejection::full);
  gateway_.rejected_stale = of(Rejection::stale);
  gateway_.rejected_numbers = of(Rejection::number);
  gateway_.rejected_identities = of(Rejection::identity);
  gateway_.rejected_malformed = of(Rejection::malformed);
  gateway_.rejected_state = of(Rejection::state);
  gateway_.rejected_other_daemon = of(Rejection::other_daemon);
}

SteadyTime CommonStatus::step(SteadyTime now) {
  const std::optional<SteadyTime> look = peers_.step(now);
  dirty_ = dirty_ || peers_.count() != gateway_.incompatible;
  gateway_.incompatible = peers_.count();
  if (dirty_ || now - published_ >= kPeriod) {
    (void)gateway_writer_.write(gateway_);
    dirty_ = false;
    published_ = now;
  }
  return look ? std::min(*look, published_ + kPeriod) : published_ + kPeriod;
}

}  // namespace cansyncd
