#include "daemon/status/common_status.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <tuple>

#include "can/bus_names.h"
#include "daemon_config/bit_timing_check.h"
#include "dds/bounded_text.h"

namespace cansyncd {
namespace {

using gateway::dds::copy_text;
using gateway::dds::text;

/// Of this computer; empty when the system does not tell.
std::string_view host_name(std::array<char, 256>& memory) noexcept {
  memory = {};
  if (gethostname(memory.data(), memory.size() - 1) != 0) return {};
  return memory.data();
}

/// The word of the configuration.
std::string_view word(SyncOutput output) noexcept {
  switch (output) {
    case SyncOutput::none:
      return "none";
    case SyncOutput::gpio:
      return "gpio";
    case SyncOutput::phc:
      return "phc";
    case SyncOutput::can:
      return "can";
  }
  return "unknown";
}

/// Likewise.
std::string_view word(SyncInput input) noexcept {
  switch (input) {
    case SyncInput::none:
      return "none";
    case SyncInput::gpio:
      return "gpio";
    case SyncInput::pps:
      return "pps";
    case SyncInput::can:
      return "can";
  }
  return "unknown";
}

// What does not change while the daemon runs.

gateway_GatewayStatus lasting_gateway(const DaemonConfig& config, std::string_view protocol,
                                      const DaemonIdentity& identity) {
  gateway_GatewayStatus status = {};
  std::array<char, 256> memory;
  copy_text(config.bus.name, status.bus);
  status.data_model = gateway_DATA_MODEL;
  copy_text(protocol, status.protocol);
  copy_text(CANSYNC_VERSION, status.version);
  std::copy(identity.begin(), identity.end(), std::begin(status.daemon));
  copy_text(host_name(memory), status.host);
  status.process = static_cast<std::uint32_t>(getpid());
  status.secured = !config.dds.security.empty();
  return status;
}

gateway_BusStatus lasting_bus(const BusConfig& config) {
  gateway_BusStatus status = {};
  copy_text(config.interface, status.bus_interface);
  status.bit_rate = config.bits_per_second;
  status.sample_point_wanted = wanted_sample_point(config);
  status.restart_time = -1;
  copy_text(config.adapter, status.adapter_wanted);
  return status;
}

gateway_RealtimeStatus lasting_realtime(const SyncConfig& config) {
  gateway_RealtimeStatus status = {};
  status.realtime_cpu = status.realtime_cpu_wanted = -1;
  copy_text(word(config.output), status.sync_output);
  copy_text(config.output == SyncOutput::phc ? word(config.output) : word(config.input), status.sync_input);
  return status;
}

/// State of the interface, or when that is up, what becomes of the frames.
std::string_view link_state(const can::ControllerStatus& bus) noexcept {
  const bool delivers = bus.link != can::LinkState::up || bus.delivery == can::Delivery::normal;
  return delivers ? name(bus.link) : name(bus.delivery);
}

}  // namespace

template <class T>
void CommonStatus::Topic<T>::step(SteadyTime now) {
  if (!is_due(now)) return;
  (void)writer.write(sample);
  dirty = false;
  published = now;
}

CommonStatus::CommonStatus(const gateway::dds::Participant& participant, EventPublisher& events,
                           const DaemonConfig& config, std::string_view protocol,
                           const DaemonIdentity& identity)
    : peers_(participant, events),
      events_(events),
      security_(config.dds.security),
      identity_(security_.empty() ? std::nullopt : gateway::dds::identity_end(security_)),
      follows_(config.sync.input != SyncInput::none || config.sync.output == SyncOutput::phc),
      gateway_(participant),
      bus_(participant),
      realtime_(participant) {
  gateway_.sample = lasting_gateway(config, protocol, identity);
  bus_.sample = lasting_bus(config.bus);
  realtime_.sample = lasting_realtime(config.sync);
  set_access(config.access);
  set_network(participant.options(), "");
}

void CommonStatus::set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) noexcept {
  gateway_RealtimeStatus& status = realtime_.sample;
  status.realtime_enforced = wanted.enforce;
  status.realtime_priority = granted.scheduling ? wanted.priority : 0;
  status.realtime_priority_wanted = wanted.priority;
  status.realtime_cpu = granted.affinity ? wanted.cpu : -1;
  status.realtime_cpu_wanted = wanted.cpu;
  status.memory_locked = wanted.lock_memory && granted.memory_locked;
  status.memory_lock_wanted = wanted.lock_memory;
  // What was not asked for counts as granted.
  status.cpu_held_awake = wanted.hold_cpu_awake && granted.cpu_held_awake;
  realtime_.dirty = true;
}

void CommonStatus::set_access(const AccessConfig& access) noexcept {
  gateway_.sample.read_only = access.read_only;
  gateway_.dirty = true;
}

void CommonStatus::set_surroundings(const Surroundings& surroundings) noexcept {
  copy_text(surroundings.configuration_reason, gateway_.sample.configuration_reason);
  copy_text(surroundings.name_taken_by, gateway_.sample.name_taken_by);
  gateway_.dirty = true;
}

void CommonStatus::set_network(const gateway::dds::ParticipantOptions& where,
                               std::string_view reason) noexcept {
  const bool local = where.xml.empty() && where.interface == "lo";
  copy_text(where.xml.empty() ? std::string_view(where.interface) : "", gateway_.sample.dds_interface);
  copy_text(local ? "local" : "joined", gateway_.sample.network);
  copy_text(reason, gateway_.sample.network_reason);
  gateway_.dirty = true;
}

bool CommonStatus::set_pending_restart(const PendingRestart& pending) noexcept {
  const gateway_GatewayStatus before = gateway_.sample;
  copy_text(pending.installed_version, gateway_.sample.installed_version);
  copy_text(pending.reason, gateway_.sample.restart_reason);
  const bool changed = text(before.restart_reason) != text(gateway_.sample.restart_reason);
  gateway_.dirty = gateway_.dirty || changed;
  return changed;
}

void CommonStatus::set_clients(std::size_t clients, const RejectionCounts& rejections) noexcept {
  gateway_GatewayStatus& status = gateway_.sample;
  status.clients = static_cast<std::uint32_t>(clients);
  const auto of = [&rejections](Rejection kind) { return rejections[static_cast<unsigned>(kind)]; };
  status.rejected_values = of(Rejection::value);
  status.rejected_full = of(Rejection::full);
  status.rejected_stale = of(Rejection::stale);
  status.rejected_numbers = of(Rejection::number);
  status.rejected_identities = of(Rejection::identity);
  status.rejected_malformed = of(Rejection::malformed);
  status.rejected_state = of(Rejection::state);
  status.rejected_other_daemon = of(Rejection::other_daemon);
}

void CommonStatus::set_link(const can::LinkFacts& link) noexcept {
  gateway_BusStatus& status = bus_.sample;
  status.sample_point = link.timing ? link.timing->sample_point : 0u;
  status.restart_time = link.restart_ms ? static_cast<std::int32_t>(*link.restart_ms) : -1;
  status.queue_length = link.queue_length;
  copy_text(can::text_of(link.adapter), status.adapter);
  bus_.dirty = true;
}

void CommonStatus::set_snapshot(const CommonSnapshot& snapshot) noexcept {
  const auto essence = [](const CommonSnapshot& of) {
    return std::tuple(of.controller.state, of.controller.link, of.controller.delivery, of.timestamps);
  };
  bus_.dirty = bus_.dirty || essence(snapshot) != essence(snapshot_);
  realtime_.dirty = realtime_.dirty || snapshot.sync.state != snapshot_.sync.state;
  snapshot_ = snapshot;
}

void CommonStatus::fill_bus() noexcept {
  const can::ControllerStatus& controller = snapshot_.controller;
  gateway_BusStatus& status = bus_.sample;
  copy_text(name(controller.state), status.controller_state);
  copy_text(link_state(controller), status.link_state);
  copy_text(name(snapshot_.timestamps), status.timestamp_source);
  status.interface_bit_rate = controller.bits_per_second;
  status.transmit_errors = controller.transmit_errors;
  status.receive_errors = controller.receive_errors;
  status.error_frames = controller.error_frames;
  status.acknowledge_errors = controller.acknowledge_errors;
  status.restarts = controller.restarts;
  status.queue_full = controller.queue_full;
  status.overruns = controller.overruns;
  status.dropped_frames = controller.dropped;
}

void CommonStatus::fill_realtime() noexcept {
  const SyncSnapshot& line = snapshot_.sync;
  gateway_RealtimeStatus& status = realtime_.sample;
  if (follows_) copy_text(sync_line::name(line.state), status.sync_state);
  status.sync_phase_error = line.phase_error.count();
  status.sync_holdover = static_cast<std::uint64_t>(line.holdover.count());
  status.sync_edges = line.edges;
  status.sync_rejected_edges = line.rejected_edges;
  status.sync_output_failures = line.output_failures;
  status.missed_syncs = snapshot_.missed_syncs;
  status.lost_reports = snapshot_.lost_reports;
}

void CommonStatus::look_at_identity(SteadyTime now) {
  if (!identity_.is_used()) return;
  const auto wall = std::chrono::system_clock::now();
  if (now >= identity_due_) {
    identity_due_ = now + IdentityWatch::kPeriod;
    if (const auto event = identity_.look(wall, gateway::dds::identity_end(security_)))
      events_.publish(*event, now);
  }
  gateway_.sample.identity_time_left = identity_.time_left(wall).count();
}

SteadyTime CommonStatus::step(SteadyTime now) {
  look_at_identity(now);
  const std::optional<SteadyTime> look = peers_.step(now);
  gateway_.dirty = gateway_.dirty || peers_.count() != gateway_.sample.incompatible;
  gateway_.sample.incompatible = peers_.count();
  gateway_.step(now);
  if (bus_.is_due(now)) fill_bus();
  bus_.step(now);
  if (realtime_.is_due(now)) fill_realtime();
  realtime_.step(now);
  const SteadyTime due = std::min({gateway_.published, bus_.published, realtime_.published}) + kPeriod;
  return look ? std::min(*look, due) : due;
}

}  // namespace cansyncd
