#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cansync.h"
#include "cansync/config/config.h"
#include "cansync/dds/topics.h"
#include "daemon/cansync/exchange.h"
#include "daemon/cansync/status/profile_topic.h"
#include "daemon/cansync/status/reference_status.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/service/daemon_identity.h"
#include "dds/endpoint.h"
#include "dds/participant.h"

namespace cansyncd {

/// What was told last.
struct ToldStatus {
  const cansync_MasterStatus* master = nullptr;
  std::vector<const cansync_SlaveStatus*> slaves;  ///< configured ones, in the order of their numbers
  const cansync_Timing* timing = nullptr;          ///< null: none yet
  const TimingSnapshot* timing_snapshot = nullptr;
};

/// Publishes what is known of the line: ActualValues, SlaveStatus, MasterStatus, Timing and, when the
/// configuration switches it on, Interval. Gateway thread only.
class StatePublisher {
 public:
  /// Least time between two samples of SlaveStatus of one slave; the newest status is always told in the end.
  static constexpr std::chrono::milliseconds kSlavePeriod{100};
  /// MasterStatus is told at least this often.
  static constexpr std::chrono::seconds kMasterPeriod{1};
  static constexpr std::chrono::milliseconds kGiversPeriod{20};

  /// Throws gateway::dds::SetupError.
  StatePublisher(const gateway::dds::Participant& participant, const Config& config,
                 const DaemonIdentity& daemon);

  /// Takes names, units and scaling from `config`; they are published with the next `step`.
  void set_names(const Config& config);

  /// Who gives the reference values, for MasterStatus; must outlive this object. Before `start`.
  void set_givers(const std::array<ReferenceGiver, cansync::kChannels>& givers) noexcept {
    givers_ = &givers;
  }

  /// Takes what is new from `exchange` and publishes what is due. Returns when to call again at the latest.
  SteadyTime step(Exchange& exchange, SteadyTime now);

  /// Publishes changed settings at once: before the reply to the command that has changed them.
  void tell_settings(Exchange& exchange, SteadyTime now);

  /// Newest state of the master, as far as it was told.
  const MasterSnapshot& master() const noexcept { return master_; }
  /// The samples of MasterStatus, SlaveStatus and Timing that were told last; after the first `step`. Valid
  /// until the next call of this object.
  ToldStatus told() const;

  /// Newest settings in force.
  const SettingsSnapshot& settings() const noexcept { return settings_; }

 private:
  struct Slave {
    SlaveReport report;
    std::array<std::uint64_t, cansync::kChannels> told = {};  ///< count of telegrams that were published
    std::array<cansync_ValueName, cansync::kValues> names = {};
    bool dirty = false;                              ///< something is to be told
    bool has_other_values = false;                   ///< and at once: mapping, names or scaling are others
    std::optional<cansync_SlaveStatus> told_status;  ///< the newest sample
    SteadyTime published;
  };

  void take_settings(Exchange& exchange);
  void take_master(Exchange& exchange);
  void take_slaves(Exchange& exchange);
  void take_actual(Exchange& exchange);
  void tell_other_values(SteadyTime now);
  void publish_master(SteadyTime now);
  void publish_slave(cansync::SlaveNumber number, SteadyTime now);

  Config config_;
  DaemonIdentity daemon_;
  gateway::dds::Writer<cansync_ActualValues> actual_writer_;
  gateway::dds::Writer<cansync_SlaveStatus> slave_writer_;
  gateway::dds::Writer<cansync_MasterStatus> master_writer_;
  gateway::dds::Writer<cansync_Timing> timing_writer_;
  gateway::dds::Writer<cansync_Interval> interval_writer_;
  ProfileTopic profiles_;

  std::array<Slave, cansync::kSlaves> slaves_;
  MasterSnapshot master_;
  const std::array<ReferenceGiver, cansync::kChannels>* givers_ = nullptr;
  std::array<ReferenceGiver, cansync::kChannels> told_givers_;
  cansync_MasterStatus told_master_ = {};
  TimingSnapshot timing_;
  std::optional<cansync_Timing> told_timing_;
  SettingsSnapshot settings_;
  bool master_dirty_ = true;
  SteadyTime master_published_;
};

}  // namespace cansyncd
