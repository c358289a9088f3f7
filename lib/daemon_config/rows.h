#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "config/rows.h"
#include "daemon_config/daemon_config.h"

/// The daemon's own rows of options. Every protocol's table of options has them beside its own.
namespace cansyncd {

using config::Option;
using config::OptionType;
using config::Value;

using DaemonRow = config::Row<DaemonConfig>;

namespace rows {

std::span<const DaemonRow> daemon_options();   ///< bus, realtime, recorder, dds, sim
std::span<const DaemonRow> access_options();   ///< access
std::span<const DaemonRow> record_options();   ///< access, of protocols whose clients send again and again
std::span<const DaemonRow> metrics_options();  ///< metrics
std::span<const DaemonRow> sync_options();     ///< sync

/// `rows` but for those of `keys`.
std::vector<DaemonRow> without(std::span<const DaemonRow> rows, std::span<const std::string_view> keys);

/// `rows` but for those that mean nothing without slaves, intervals and SYNC edges.
std::vector<DaemonRow> without_intervals(std::span<const DaemonRow> rows);

/// The option by which a file chooses its protocol, as it stands in the table of one protocol: `name` is that
/// protocol's, `initial` the same in TOML's notation. It belongs first into the section `bus`.
constexpr Option protocol_option(std::string_view name, std::string_view initial) {
  return config::rows::choice(
      "bus.protocol", initial, name,
      "What the daemon is on this bus. Each protocol has its own options; those of another one are refused.");
}

}  // namespace rows
}  // namespace cansyncd
