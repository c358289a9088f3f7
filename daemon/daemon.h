#pragma once

#include <string>
#include <vector>

#include "daemon/cansync/config/file.h"

namespace cansyncd {

/// Reads and checks a configuration completely: the file, what stands behind it, and whether this version can
/// run it. Main thread.
ConfigFile load_checked(const std::string& path, const std::vector<std::string>& overrides);

/// Exit codes of the program.
namespace exit_code {
inline constexpr int done = 0;           ///< stopped by a signal, or nothing to complain about
inline constexpr int cannot_start = 1;   ///< bus, DDS or realtime thread cannot be had
inline constexpr int wrong_usage = 2;    ///< wrong command line
inline constexpr int wrong_config = 78;  ///< wrong configuration; EX_CONFIG, not to be tried again
}  // namespace exit_code

/// Runs the daemon with a configuration that has no problems until SIGTERM or SIGINT; SIGHUP reads the file
/// again with the same overrides. Returns an exit code. Main thread, before any other thread exists.
int run_daemon(ConfigFile file, const std::vector<std::string>& overrides);

}  // namespace cansyncd
