#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "cansync/settings/settings.h"
#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"
#include "daemon_config/daemon_config.h"
#include "profile/profile.h"

/// The whole configuration of a CANsync master on one bus: plain values. `file.h` reads it from a TOML file;
/// docs/configuration.md lists every option. Not for the realtime thread, except `Config::master`, which is
/// copied into the master.
namespace cansyncd {

/// How far the daemon goes by itself after its start.
enum class StartTarget : std::uint8_t {
  none,    ///< waiting for start; clients give the mode commands
  setup,   ///< set-up: SYNC runs, slaves are activated, the command channel is served
  active,  ///< set-up, then active operation as soon as the enable rule allows
};

/// What the daemon does when another master has gone that kept it silent.
enum class AfterOtherMaster : std::uint8_t {
  resume,   ///< it goes to its target
  command,  ///< it waits for a mode command
};

/// Start-up. What concerns the master alone is in `Config::master.startup`.
struct StartConfig {
  StartTarget target = StartTarget::active;
  /// Before the first frame, also after the bus was away. On a simulated bus, where there is no other master,
  /// only when it is given.
  std::chrono::milliseconds listen{1000};
  AfterOtherMaster after_other_master = AfterOtherMaster::resume;
};

/// What happens when the writer of reference values dies, leaves, or falls silent. New values end each.
enum class LossReaction : std::uint8_t {
  stop_release,  ///< no reference value telegrams of that channel
  hold,          ///< a running release goes on with its last values for a limited time, then stops
  control_word,  ///< the release stops, and a control word is sent to slaves
};

/// Failsafe behaviour of the reference values. How old they may grow on the bus is
/// `Config::master.process.too_old_after`.
struct FailsafeConfig {
  LossReaction reaction = LossReaction::stop_release;
  std::uint32_t hold_intervals = 50;                      ///< 1..60'000
  std::optional<std::uint16_t> control_word;              ///< given when it is the reaction
  std::optional<cansync::SlaveMask> control_word_slaves;  ///< nothing: every configured slave
  /// A writer that gives nothing new for so long has missed its deadline; 0: not looked at.
  std::chrono::milliseconds reference_deadline{0};
  /// A sample of reference values whose source time lies further away is not taken; 0: not looked at.
  std::chrono::milliseconds reference_max_age{500};
};

/// Name, unit and scaling of one value: scaled = number * factor + offset, in `unit`. The number has 16 bits
/// when the mapping carries the value's low word alone, else 32.
struct ValueConfig {
  std::string name;  ///< empty: no name; else 1..64 characters
  std::string unit;  ///< 0..16 characters
  double factor = 1.0;
  double offset = 0.0;
  bool is_signed = true;  ///< the number is two's complement
  friend bool operator==(const ValueConfig&, const ValueConfig&) = default;
};
using ValueConfigs = std::array<ValueConfig, cansync::kValues>;

/// Where a release of a reference value must begin.
struct StartWithinConfig {
  cansync::SlaveNumber slave;
  std::uint8_t value = 0;  ///< its actual value, 0..7
  double distance = 0.0;   ///< in the reference value's unit, 0 or more
  friend bool operator==(const StartWithinConfig&, const StartWithinConfig&) = default;
};

/// Limits of one reference value in its unit; nothing: no limit. `Config::master.process.reference_limits` has
/// the same as numbers.
struct ReferenceLimitsConfig {
  std::optional<double> minimum;
  std::optional<double> maximum;
  std::optional<double> max_step;
  std::optional<StartWithinConfig> start_within;
  friend bool operator==(const ReferenceLimitsConfig&, const ReferenceLimitsConfig&) = default;
};

/// What people call a slave and its actual values. Number, mapping and limits are in `Config::master.slaves`.
struct SlaveConfig {
  std::string name;  ///< default "slaveN"; 1..64 characters, unique, no number
  ValueConfigs actual = {};
  std::string profile;                                 ///< name or file of its drive profile; empty: none
  std::shared_ptr<const profile::Profile> parameters;  ///< that profile, read; null: none
  friend bool operator==(const SlaveConfig&, const SlaveConfig&) = default;
};

/// The simulated drives; looked at only with `BusKind::simulated`.
struct DrivesConfig {
  cansync::SlaveMask slaves;  ///< which slave numbers have a drive; default: every configured slave
  std::chrono::milliseconds lock_time{500};  ///< from SYNC and activation to bit 15 of the status word
  std::uint32_t memory = 256 * 1024;         ///< bytes of upload/download memory per drive
  /// Intervals in a row without reference values until a drive faults.
  std::uint16_t missing_references = 10;
  std::uint16_t missing_edges = 10;  ///< SYNC edges missing in a row until a drive faults
};

/// Everything. The bit rate stands in `bus` and in `master`; both come from one option.
struct Config : DaemonConfig {
  StartConfig startup;
  FailsafeConfig failsafe;
  cansync::MasterSettings master;  ///< bit rate, slots, slaves, mappings, polling, command channel, start-up
  std::array<SlaveConfig, cansync::kSlaves> slaves =
      {};                        ///< by slave number; see `master.slaves[n].configured`
  ValueConfigs references = {};  ///< reference values 0..7
  std::array<ReferenceLimitsConfig, cansync::kValues> reference_limits = {};  ///< likewise
  DrivesConfig drives;
};

}  // namespace cansyncd
