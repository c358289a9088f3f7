#include "cli/base/exit_codes.h"

namespace cansync::cli {

ExitCode exit_code(client::ReplyCode code) noexcept {
  switch (code) {
    case client::ReplyCode::done:
      return ExitCode::done;
    case client::ReplyCode::refused:
      return ExitCode::refused;
    case client::ReplyCode::slave_error:
    case client::ReplyCode::word_expected:
    case client::ReplyCode::doubleword_expected:
    case client::ReplyCode::value_too_wide:
      return ExitCode::slave_error;
    case client::ReplyCode::timeout:
    case client::ReplyCode::no_answer:
    case client::ReplyCode::slave_lost:
      return ExitCode::timeout;
    case client::ReplyCode::cancelled:
    case client::ReplyCode::master_stopped:
    case client::ReplyCode::replaced:
      return ExitCode::cancelled;
    case client::ReplyCode::no_reply:
    case client::ReplyCode::no_daemon:
      return ExitCode::not_reachable;
  }
  return ExitCode::failed;
}

const char* exit_code_help() noexcept {
  return "Exit codes:\n"
         "  0  done\n"
         "  1  something else failed, e.g. a file cannot be read or written\n"
         "  2  usage: the command line is wrong; nothing was sent\n"
         "  3  refused by the daemon, or by `restore` before its first write; nothing was changed\n"
         "  4  the slave answered with an error, or the parameter has another format\n"
         "  5  timeout, a write was not answered, a control word or broadcast was not seen on the bus, or "
         "the slave stopped\n     answering\n"
         "  6  the daemon is not running, not reachable, or went away\n"
         "  7  cancelled by Ctrl-C, because the master stopped, or replaced by a newer control word\n"
         "  8  `doctor` found an error (1: warnings alone)\n"
         "  9  `diff`, `verify` or `learn --compare` found a difference\n"
         " 10  the values of `set` had no effect\n"
         " 11  done, but a file was read in part: the remarks say what was left out\n"
         " 12  `scan`, `learn`: the frames do not look like CANsync; nothing was written";
}

}  // namespace cansync::cli
