#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "cansync/cluster/cluster.h"
#include "cansync/settings/timing.h"
#include "cansync/slave/slave.h"
#include "cansync_slave/config/config.h"
#include "daemon/bus/bus_load.h"
#include "daemon/cansync_slave/exchange.h"
#include "daemon/cansync_slave/realtime/answer_queue.h"
#include "daemon/cansync_slave/realtime/release_store.h"
#include "daemon/cansync_slave/realtime/slave_commands.h"
#include "daemon/cansync_slave/realtime/slave_desk.h"
#include "daemon/cansync_slave/realtime/sync_follower.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/loop/leading_edges.h"
#include "daemon/loop/wall_clock.h"
#include "sync/phase_lock.h"

namespace cansyncd {

/// What the realtime thread of a slave needs to know.
struct SlaveMachineSettings {
  cansync::SlaveSideSettings slave;
  cansync::SlaveServiceSettings service;  ///< its table has `status_parameter`
  SlaveTarget target = SlaveTarget::active;
  std::uint16_t status_parameter = 301;
  std::uint16_t status_bits = 0;
  cansync::SlaveSupervisionSettings supervision;
  sync_line::PhaseLockSettings lock;  ///< how the intervals follow the SYNC input
  bool edge_every_interval = true;    ///< false: the input has fewer edges (PPS)
  SyncFollower::Inputs inputs;
  WallClock::Read wall_clock = &read_realtime_clock;  ///< null in virtual time
  FlightTap* tap = nullptr;                           ///< flight recorder; null: none
  /// The machine drives the upper slave of this cluster instead of one of its own, and its edges lead
  /// `edges`; null: it has its own. Both must outlive the machine.
  cansync::Cluster* cluster = nullptr;
  LeadingEdges* edges = nullptr;
};

/// Binds a `cansync::Slave` to a bus, a SYNC input and the gateway; driven by `DeadlineLoop`. Realtime thread
/// only; realtime safe after its construction. In a cluster it gives the time for both buses: `begin_above`
/// at each edge of its timeline, also while that does not follow the input.
///
/// An interval begins with an edge of the timeline that follows the input, and only while it follows it. An
/// answer is handed over as soon as its request has come, and not after its latest start (docs/
/// cansync-slave.md, "What has to be in time"); then it is left out and counted.
class SlaveMachine {
 public:
  /// Bus and exchange must outlive the machine.
  SlaveMachine(const SlaveMachineSettings& settings, can::Bus& bus, SlaveExchange& exchange);

  // --- for DeadlineLoop, which says what each is
  void begin(can::Time now) noexcept;
  void advance(can::Time now) noexcept;
  void receive(const can::ReceivedFrame& received) noexcept;
  std::optional<can::Frame> next_frame() noexcept { return answers_.next(bus_.now(), slave_); }
  void handed_over(can::SendResult result) noexcept;
  bool waits_for_echo() const noexcept { return false; }
  can::Time next_deadline() const noexcept {
    return std::min(sync_.next_deadline(), answers_.next_deadline());
  }
  void publish(can::Time now) noexcept;
  void end(can::Time now) noexcept;

 private:
  void pass_edges(can::Time now) noexcept;
  void lead(const SyncFollower::Passed& passed) noexcept;
  void slave_interval(std::uint64_t passed) noexcept;
  void begin_intervals(const SyncFollower::Passed& passed) noexcept;
  void watch_faults(can::Time now) noexcept;
  void end_fault(cansync::SlaveFault fault, can::Time now) noexcept;
  void take_releases() noexcept;
  void watch_sync() noexcept;
  void tell_synchronized() noexcept;
  void set_up() noexcept;
  void take_command(can::Time now) noexcept;
  void take(const cansync::Telegram& telegram, const can::ReceivedFrame& received) noexcept;
  void take_reference(const cansync::ReferenceTelegram& telegram, can::Time end) noexcept;
  void take_actual(const cansync::ActualTelegram& telegram, std::uint32_t before, can::Time end) noexcept;
  void take_action(const cansync::ActionCommand& action, can::Time end) noexcept;
  void watch_own_number(const can::ReceivedFrame& received) noexcept;
  can::Time edge_before(can::Time end) noexcept;
  Moment moment(can::Time at) const noexcept { return {number_, at, clock_.at(at)}; }
  bool report(const SlaveSideReport& report) noexcept;
  void fill_snapshot(can::Time now) noexcept;

  can::Bus& bus_;
  SlaveExchange& exchange_;
  const cansync::SlotTimes slots_;
  FlightTap* const tap_;
  cansync::Cluster* const cluster_;
  LeadingEdges* const edges_;
  SlaveDesk desk_;
  std::optional<cansync::Slave> own_slave_;  ///< without a cluster
  cansync::Slave& slave_;
  SlaveCommands commands_;
  cansync::SlaveSupervision supervision_;
  ReleaseStore releases_;
  SyncFollower sync_;
  AnswerQueue answers_;
  WallClock clock_;
  BusLoad load_;

  std::uint64_t turns_ = 0;    ///< of the loop
  IntervalNumber number_ = 0;  ///< of the running interval
  can::Time edge_{};           ///< that it began with
  bool timed_ = false;         ///< the running interval began with an edge that follows the input
  bool fresh_ = false;         ///< the interval before brought reference values
  bool synchronized_ = false;
  int input_error_ = 0;
  can::SendResult last_send_ = can::SendResult::queued;
  bool echo_due_ = false;
  bool heard_others_ = false;
  bool own_number_told_ = false;
  std::uint64_t lost_frames_ = 0;  ///< of the controller, at the beginning of the running second
  std::uint64_t frames_ = 0;       ///< of others, within the running second
  std::array<std::uint64_t, cansync::kChannels> dropped_releases_ = {};  ///< came without intervals
  ReceivedValues references_;
  std::array<ReceivedValues, cansync::kSlaves> monitored_ = {};
  SlaveSnapshot snapshot_;
  can::Time next_second_{};
  can::Time next_status_{};
  bool changed_ = false;  ///< something that clients are told at once
  bool pending_ = false;  ///< something was written for the gateway
};

}  // namespace cansyncd
