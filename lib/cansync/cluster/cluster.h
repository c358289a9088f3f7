#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "can/frame.h"
#include "cansync/cluster/gateway.h"
#include "cansync/cluster/lead_axis.h"
#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "cansync/settings/settings_check.h"
#include "cansync/slave/slave.h"

/// A slave of an upper bus that is the master of a lower one (O 7.1.1), in one process with one timeline.
namespace cansync {

/// How the timeline follows the SYNC of the upper bus.
enum class UpperSync : std::uint8_t {
  searching,  ///< edges come, and the timeline moves towards them
  locked,
  holdover,  ///< edges stay away; the timeline goes on as it has learned
  lost,      ///< for too long
};

/// What the lower bus waits for or does.
enum class ClusterState : std::uint8_t {
  stopped,           ///< before `start`
  waiting_for_sync,  ///< no SYNC below: that of the upper bus is not followed yet, or was lost
  setting_up,        ///< SYNC below; the lower slaves are activated
  active,            ///< reference and actual values below
};
/// A stable word for a state, e.g. "waiting_for_sync"; the text lives as long as the program.
std::string_view name(ClusterState state) noexcept;

/// Everything about a cluster that can be set. Both buses have the same bit rate, so the same interval.
struct ClusterSettings {
  SlaveSideSettings upper;
  MasterSettings lower;
  GatewaySettings gateway;
  LeadSources lead = {};
  /// From the end of a telegram until its values are at hand, at most.
  Duration lead_reserve = std::chrono::microseconds(50);
  bool enable_upper = true;  ///< the slave goes to active operation at the start (K7 is open in the manuals)
  bool enable_lower = true;  ///< the master does, as soon as its enable rule lets it
};

/// Everything that is wrong with `settings` beside what `check(MasterSettings)` finds below; empty: a cluster
/// may be made of them. For set-up code: allocates.
std::vector<SettingProblem> check(const ClusterSettings& settings);

/// One line for each value of the lead axis: where it comes from, where it goes, and whether it is given in
/// the same interval or in the next one. For people; allocates.
std::vector<std::string> describe_lead_axis(const ClusterSettings& settings);

/// The two cores and what goes between them, sans-IO.
///
/// One interval: `follow` when the way in which the upper SYNC is followed has changed; `begin_interval`, or
/// its steps, at the timeline's edge, which is the lower SYNC edge when `sync_output` then says so; frames of
/// the upper bus go into `receive_above`, whose answer is handed over as `Slave` says; frames of the lower
/// bus into `lower()`; for each slot of the lower bus, at its planned start, `take`, then `lower().sent` or
/// `left_out`.
///
/// Numbers of intervals rise; over a jump no value of the lead axis is carried. All memory is taken in the
/// constructor; nothing else allocates, blocks or throws. Not thread safe: one thread owns both buses.
class Cluster {
 public:
  /// `own` answers for the gateway itself, `below` is told of the lower bus; both must outlive the cluster.
  /// Settings must have passed `check`.
  Cluster(const ClusterSettings& settings, SlaveApplication& own, MasterListener& below);
  /// The same; `serve` and `tell` come before anything else.
  explicit Cluster(const ClusterSettings& settings);
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;

  /// Who answers for the gateway itself; must outlive the cluster.
  void serve(SlaveApplication& own) noexcept { gateway_.serve(own); }
  /// Who is told of the lower bus; must outlive the cluster.
  void tell(MasterListener& below) noexcept { gateway_.tell(below); }

  /// Starts both interfaces, the slave first (O 7.1.2); the master's synchronous operation waits for SYNC.
  void start() noexcept;
  /// Ends both, the master first.
  void stop() noexcept;

  /// The upper SYNC is followed in another way.
  void follow(UpperSync sync) noexcept { sync_ = sync; }
  /// Interval `now` of the timeline begins: first the slave's part, then the master's (O 7.1.2).
  void begin_interval(IntervalNumber now) noexcept;

  // --- its three steps, for who leads both interfaces through their states by itself, without `start`
  /// The slave's part.
  void begin_above(IntervalNumber now) noexcept;
  /// Stops the lower bus when the upper SYNC is lost; after `start` begins it when that is followed.
  void decide_sync() noexcept;
  /// The master's part.
  void begin_below(IntervalNumber now) noexcept;
  /// The lower bus may have SYNC: it follows the upper one, or goes on over edges that are missing there.
  bool sync_allowed() const noexcept;

  /// The lower SYNC is to be made in this interval. Once it is made it goes on over missing edges above,
  /// until those are lost, or the lower master has to be silent (`Master::silent`).
  bool sync_output() const noexcept { return is_synchronous(lower_.state()) && !lower_.silent(); }

  /// A frame was on the upper bus until `since_sync`; as `Slave::receive`.
  std::optional<SlaveAnswer> receive_above(const can::Frame& frame, Duration since_sync) noexcept;
  /// The same for a frame that is already decoded.
  std::optional<SlaveAnswer> receive_above(const Telegram& telegram, Duration since_sync) noexcept;
  /// As `Slave::release_actual`, once an interval right after its beginning; the lead axis may have the
  /// values.
  void release_actual(Channel channel, const Values& values) noexcept;

  /// The frame for a slot of the lower bus; as `Master::take`.
  std::optional<can::Frame> take(Slot slot) noexcept;

  /// The slave of the upper bus; its frames and releases go through the cluster.
  Slave& upper() noexcept { return upper_; }
  const Slave& upper() const noexcept { return upper_; }
  /// The master of the lower bus; its intervals and slots go through the cluster.
  Master& lower() noexcept { return lower_; }
  const Master& lower() const noexcept { return lower_; }
  /// What passes jobs on.
  ClusterGateway& gateway() noexcept { return gateway_; }
  /// What passes values on.
  LeadAxis& lead() noexcept { return lead_; }
  const LeadAxis& lead() const noexcept { return lead_; }

  /// As of the last interval.
  ClusterState state() const noexcept;
  /// Times the lower bus was stopped because the upper SYNC was lost.
  std::uint64_t sync_losses() const noexcept { return sync_losses_; }

 private:
  void initialise_lower() noexcept;
  std::optional<can::Frame> take_reference(Channel channel, Slot slot) noexcept;
  bool tracking() const noexcept { return sync_ == UpperSync::locked || sync_ == UpperSync::holdover; }

  ClusterSettings settings_;
  ClusterGateway gateway_;
  Slave upper_;
  Master lower_;
  LeadAxis lead_;
  UpperSync sync_ = UpperSync::searching;
  bool started_ = false;
  bool first_ = true;
  IntervalNumber now_ = 0;
  std::uint64_t sync_losses_ = 0;
};

}  // namespace cansync
