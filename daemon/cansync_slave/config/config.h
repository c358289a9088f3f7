#pragma once

#include <chrono>
#include <cstdint>

#include "cansync/slave/slave.h"
#include "cansync/slave/slave_supervision.h"
#include "daemon/config/daemon_config.h"

/// The whole configuration of a CANsync slave: plain values. `file.h` reads it from a TOML file. Not for the
/// realtime thread, except `SlaveRoleConfig::slave`, which is copied into the slave.
namespace cansyncd {

/// How far the slave goes by itself after its start.
enum class SlaveTarget : std::uint8_t {
  none,    ///< waiting for start: nothing is heard
  setup,   ///< set-up: actions, parameters and transfers
  active,  ///< process data, too
};

/// Everything. The bit rate stands in `bus` and in `slave`; both come from one option.
struct SlaveRoleConfig : DaemonConfig {
  cansync::SlaveSideSettings slave;
  SlaveTarget target = SlaveTarget::active;
  std::uint16_t status_parameter = 301;           ///< 0..4095
  std::uint16_t status_bits = 0;                  ///< of the status word, beside bit 15
  cansync::SlaveSupervisionSettings supervision;  ///< its interval follows from the bit rate
};

}  // namespace cansyncd
