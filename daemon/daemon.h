#pragma once

#include <span>
#include <string>

#include "daemon/segment/protocol.h"

namespace cansyncd {

/// Exit codes of the program.
namespace exit_code {
inline constexpr int done = 0;           ///< stopped by a signal, or nothing to complain about
inline constexpr int cannot_start = 1;   ///< bus, DDS or realtime thread cannot be had
inline constexpr int wrong_usage = 2;    ///< wrong command line
inline constexpr int wrong_config = 78;  ///< wrong configuration; EX_CONFIG, not to be tried again
}  // namespace exit_code

/// Runs the daemon with a configuration that has no problems until SIGTERM or SIGINT; SIGHUP reads the file
/// `path` again with the same overrides. Returns an exit code. Main thread, before any other thread exists.
int run_daemon(const LoadedConfig& config, const std::string& path, std::span<const std::string> overrides);

}  // namespace cansyncd
