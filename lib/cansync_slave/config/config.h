#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cansync/slave/slave.h"
#include "cansync/slave/slave_service.h"
#include "cansync/slave/slave_supervision.h"
#include "daemon_config/daemon_config.h"
#include "profile/profile.h"

/// The whole configuration of a CANsync slave: plain values. `file.h` reads it from a TOML file. Not for the
/// realtime thread, except `SlaveRoleConfig::slave`, which is copied into the slave.
namespace cansyncd {

/// How far the slave goes by itself after its start.
enum class SlaveTarget : std::uint8_t {
  none,    ///< waiting for start: nothing is heard
  setup,   ///< set-up: actions, parameters and transfers
  active,  ///< process data, too
};

/// What the simulated master asks of this slave, again and again: a parameter, a block, a control word or
/// another action.
struct SimulatedJob {
  unsigned number = 0;                     ///< of its section
  std::optional<std::uint16_t> parameter;  ///< 0..4095
  std::optional<std::uint32_t> value;      ///< it is written; else it is read
  std::uint16_t sub_slave = 0;             ///< sub-slave address; 0: the slave itself
  std::uint32_t address = 0;               ///< of a block; 0x100 and over
  std::uint16_t bytes = 0;                 ///< of a block: its length; 0: none
  bool download = false;                   ///< of a block: to the slave, byte n is n modulo 256; else from it
  std::optional<std::uint16_t> control_word;  ///< it is given
  std::optional<std::uint8_t> action;         ///< 128..255: that command is given
  std::uint8_t data_byte = 0;                 ///< of the action
  std::uint16_t data_word = 0;                ///< likewise
  std::uint32_t every = 1000;                 ///< intervals
};

/// Everything. The bit rate stands in `bus` and in `slave`; both come from one option.
struct SlaveRoleConfig : DaemonConfig {
  cansync::SlaveSideSettings slave;
  SlaveTarget target = SlaveTarget::active;
  std::uint16_t status_parameter = 301;  ///< 0..4095
  std::uint16_t status_bits = 0;         ///< of the status word, beside bit 15
  std::string profile;                   ///< drive profile of this slave, name or file; empty: none
  std::shared_ptr<const profile::Profile> parameters;  ///< what it says; null: none
  /// Its table with the status word.
  cansync::SlaveServiceSettings service{
      .parameters = {}, .jobs = {.answer_time = std::chrono::seconds(5)}, .area = {}};
  std::vector<SimulatedJob> simulated_jobs;
  cansync::SlaveSupervisionSettings supervision;  ///< its interval follows from the bit rate
};

}  // namespace cansyncd
