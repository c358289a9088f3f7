#pragma once

#include <cansync/types.h>

#include <cstdint>

namespace cansync::cli {

/// Exit code of the program; docs/command-line.md and `cansync --help` list them.
enum class ExitCode : std::uint8_t {
  done = 0,
  failed = 1,       ///< anything that has no code of its own, e.g. a file that cannot be written; warnings of
                    ///< `doctor`
  usage = 2,        ///< the command line is wrong; nothing was sent
  refused = 3,      ///< by the daemon: nothing was sent on the bus; or by `restore`: nothing was written
  slave_error = 4,  ///< the slave answered with an error, or has the parameter in another format
  timeout = 5,      ///< no answer of the slave; after a write it is not known whether it was taken
  not_reachable = 6,  ///< no daemon, or it went away before it answered
  cancelled = 7,      ///< by Ctrl-C, because the master stopped, or replaced by a newer control word
  faults = 8,         ///< `doctor` found an error
  different = 9,      ///< `diff`, `verify` or `learn --compare` found one
  no_effect = 10,     ///< `set`: not one value reached the line
  in_part = 11,       ///< done, but a file was read in part: what was left out is shown
  not_cansync = 12,   ///< `scan`, `learn`: the frames do not look like CANsync; nothing was written
};

/// The exit code of a request that ended so.
ExitCode exit_code(client::ReplyCode code) noexcept;

/// The table of exit codes for `cansync --help`.
const char* exit_code_help() noexcept;

}  // namespace cansync::cli
