#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "cansync_slave/config/config.h"
#include "cansync_slave/config/parameter_rows.h"
#include "config/print.h"
#include "config/rows.h"

/// The options of a slave. Main thread.
namespace cansyncd {

/// Value of `bus.protocol`.
inline constexpr std::string_view kSlaveProtocol = "cansync-slave";

/// Register bytes of one telegram's mapping, as they were given.
using MappingBytes = std::optional<std::array<std::uint8_t, cansync::kWords>>;
/// Of both telegrams.
using MappingBytesOfBoth = std::array<MappingBytes, cansync::kChannels>;

/// Configuration while it is being read.
struct SlaveRoleDraft {
  /// One [[monitored]].
  struct Monitored {
    bool given = false;
    MappingBytesOfBoth mapping;
  };

  SlaveRoleConfig config;
  bool numbered = false;  ///< slave.number was given
  MappingBytesOfBoth reference;
  MappingBytesOfBoth actual;
  std::array<Monitored, cansync::kSlaves> monitored = {};
  unsigned number = 0;  ///< of the section an option belongs to
  cansync_slave::ParameterSections parameters;
  std::map<unsigned, SimulatedJob> jobs;
  std::uint16_t unknown_parameter_error = 0xFFFA;

  void begin(unsigned section) { number = parameters.number = section; }
};

/// Every row: the daemon's, with the SYNC input, and those of a slave.
const config::Rows<SlaveRoleDraft>& slave_option_rows();

/// The table of the rows.
const config::Table& slave_options();

/// What its documents begin with.
extern const config::DocumentHeads slave_document_heads;

}  // namespace cansyncd
