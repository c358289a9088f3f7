#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "can/bus.h"
#include "can/link_facts.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/rejections.h"
#include "daemon/loop/sync_snapshot.h"
#include "daemon/service/daemon_identity.h"
#include "daemon/service/pending_restart.h"
#include "daemon/service/surroundings.h"
#include "daemon/status/identity_watch.h"
#include "daemon/status/incompatible_peers.h"
#include "daemon_config/daemon_config.h"
#include "dds/endpoint.h"
#include "dds/participant.h"
#include "gateway.h"
#include "rt/realtime_thread.h"

namespace cansyncd {

/// What a realtime thread tells whatever its protocol; the defaults stand for what a protocol does not have.
struct CommonSnapshot {
  can::ControllerStatus controller;
  can::TimestampSource timestamps = can::TimestampSource::thread;
  SyncSnapshot sync;
  std::uint64_t missed_syncs = 0;
  std::uint64_t lost_reports = 0;
  bool in_run = false;  ///< a stop of this computer would stop a machine
};

/// The samples as they are known; after the first `step` they were told.
struct ToldCommon {
  const gateway_GatewayStatus& gateway;
  const gateway_BusStatus& bus;
  const gateway_RealtimeStatus& realtime;
};

/// Publishes the status that is true of a bus whatever its protocol: GatewayStatus, BusStatus and
/// RealtimeStatus, each on every change and once a second; counters wait for the next second. It also
/// tells of programs that do not match. Gateway thread only, but for `set_realtime`.
class CommonStatus {
 public:
  /// Each topic is told at least this often.
  static constexpr std::chrono::seconds kPeriod{1};

  /// Throws gateway::dds::SetupError.
  CommonStatus(const gateway::dds::Participant& participant, EventPublisher& events,
               const DaemonConfig& config, std::string_view protocol, const DaemonIdentity& identity);

  /// What the realtime thread asked for and was granted. Before the gateway thread runs.
  void set_realtime(const rt::RealtimeSettings& wanted, const rt::Grants& granted) noexcept;

  /// Who may do what from now on.
  void set_access(const AccessConfig& access) noexcept;

  /// What is true around the bus from now on.
  void set_surroundings(const Surroundings& surroundings) noexcept;
  /// Where DDS is from now on; `reason`: why not where it is to be, empty: it is there.
  void set_network(const gateway::dds::ParticipantOptions& where, std::string_view reason) noexcept;
  /// What waits for a restart. False: that is what was shown before.
  bool set_pending_restart(const PendingRestart& pending) noexcept;

  /// How many clients there are, and what of them was rejected.
  void set_clients(std::size_t clients, const RejectionCounts& rejections) noexcept;

  /// What the kernel knows of the bus's interface.
  void set_link(const can::LinkFacts& link) noexcept;

  /// What the realtime thread told last.
  void set_snapshot(const CommonSnapshot& snapshot) noexcept;

  /// Publishes what is due. Returns when to call again at the latest.
  SteadyTime step(SteadyTime now);

  /// What every program of the bus reads.
  const gateway::dds::WriterBase& gateway_writer() const noexcept { return gateway_.writer; }

  /// Valid while this object lives.
  ToldCommon told() const noexcept { return {gateway_.sample, bus_.sample, realtime_.sample}; }

 private:
  /// One topic.
  template <class T>
  struct Topic {
    explicit Topic(const gateway::dds::Participant& participant) : writer(participant) {}
    bool is_due(SteadyTime now) const noexcept { return dirty || now - published >= kPeriod; }
    void step(SteadyTime now);

    gateway::dds::Writer<T> writer;
    T sample = {};
    bool dirty = true;
    SteadyTime published;
  };

  void look_at_identity(SteadyTime now);
  void fill_bus() noexcept;
  void fill_realtime() noexcept;

  IncompatiblePeers peers_;
  EventPublisher& events_;
  const std::string security_;  ///< folder of the identity
  IdentityWatch identity_;
  SteadyTime identity_due_{};
  const bool follows_;  ///< the timeline follows something
  Topic<gateway_GatewayStatus> gateway_;
  Topic<gateway_BusStatus> bus_;
  Topic<gateway_RealtimeStatus> realtime_;
  CommonSnapshot snapshot_;
};

}  // namespace cansyncd
