#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/document.h"
#include "config/option.h"
#include "config/print.h"
#include "config/problem.h"
#include "daemon/segment/segment.h"
#include "daemon/service/journal.h"
#include "daemon_config/daemon_config.h"
#include "dds/participant.h"

/// What a protocol is to the daemon. A new one is a folder `daemon/NAME/` with its own CMakeLists.txt that
/// adds its sources to the target `cansync_daemon`, and one line in `lib/protocols.def`.
namespace cansyncd {

/// A configuration as a protocol has read it. Main thread.
struct LoadedConfig {
  std::string path;  ///< of the file
  /// Everything found wrong, in the order of the file. Not empty: of the rest only the path and the bus's
  /// name are there.
  std::vector<config::Problem> problems;
  /// Of drive profiles that are missing or wrong: the daemon runs without their names and limits.
  std::vector<config::Problem> profile_problems;
  /// Of the fault script of a simulated bus: the daemon runs without the faults that these are in.
  std::vector<config::Problem> script_problems;
  std::optional<std::string> text;  ///< of the file, as it was read; nothing: it could not be
  /// Since when a configuration is known that runs in place of the file, "2026-11-27 21:04:53 UTC"; empty: it
  /// is the file's own.
  std::string kept_since;
  DaemonConfig daemon;  ///< the daemon's part; defaults when the file is wrong
  /// The daemon's part for each bus, of a file that is for several; empty: it is for one, `daemon`.
  std::vector<DaemonConfig> buses;
  /// What `--check` tells beside "in order": lines that end with a line feed; may be empty.
  std::string check_text;
  /// The bus as a DBC file; empty: the protocol has none. Called at most once.
  std::function<std::string()> dbc_text;
  /// Makes the segment on the participants of its buses' DDS options, in their order, which it may move from.
  /// Called at most once, before any thread
  /// runs but those of the journal and DDS; the journal must outlive the segment. Throws a std::exception
  /// that names what cannot be had and the remedy.
  std::function<std::unique_ptr<Segment>(JournalSink& journal,
                                         std::span<gateway::dds::Participant> participants)>
      make_segment;

  /// Every bus that the file is for.
  std::span<const DaemonConfig> served() const noexcept {
    return buses.empty() ? std::span(&daemon, 1) : std::span<const DaemonConfig>(buses);
  }
};

/// One protocol. All members are needed; the functions are for the main thread.
struct ProtocolInfo {
  std::string_view name;  ///< value of `bus.protocol`: a literal of lower-case letters, digits and '-'

  /// Every option of its files: the daemon's rows (lib/daemon_config/rows.h), with `rows::protocol_option`
  /// first, and its own. What stands in no row is refused by the reader, with line and column.
  const config::Table& (*options)();

  /// Reads and checks a file completely, also what stands behind it (other files, rights). `overrides` are
  /// "KEY=VALUE" and win over the file. Never throws for a wrong file.
  LoadedConfig (*load)(const config::Source& source, std::span<const std::string> overrides);

  /// What docs/configuration.md, a file with every option at its default, and cansync.toml(5) say of it
  /// before they tell its options.
  const config::DocumentHeads* heads;
};

}  // namespace cansyncd
