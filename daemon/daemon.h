#pragma once

#include <span>
#include <string>

#include "daemon/configuration_watch.h"
#include "daemon/kept_configurations.h"
#include "daemon/segment/protocol.h"

namespace cansyncd {

/// Exit codes of the program.
namespace exit_code {
inline constexpr int done = 0;           ///< stopped by a signal, or nothing to complain about
inline constexpr int cannot_start = 1;   ///< bus, DDS or realtime thread cannot be had
inline constexpr int wrong_usage = 2;    ///< wrong command line
inline constexpr int wrong_config = 78;  ///< wrong configuration; EX_CONFIG, not to be tried again
}  // namespace exit_code

/// What keeps a line going when its file is wrong at the next start.
struct Continuity {
  LoadConfiguration load = {};  ///< looks at the files while they run; empty: they are not looked at
  KeptConfigurations kept{""};  ///< where each configuration that has run is kept
};

/// Runs the daemon until SIGTERM or SIGINT, a bus for each of the files: at least one, without problems, each
/// alone and together. SIGHUP reads them again with the same overrides. Returns an exit code. Main thread,
/// before any other thread exists.
int run_daemon(std::span<const LoadedConfig> files, std::span<const std::string> overrides,
               const Continuity& continuity = {});

}  // namespace cansyncd
