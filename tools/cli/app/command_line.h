#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/base/session.h"
#include "cli/base/verbs.h"

/// A command line of this program taken apart. Main thread only.
namespace cansync::cli {

/// One command, ready to run.
struct Command {
  Globals globals;
  std::string name;  ///< of the verb; empty: help or version was asked for
  Verb verb;
};

/// Reads the words of a command line, without the program's name. Throws UsageError.
Command parse_command(const std::vector<std::string>& words);

/// Reads the words of a line of a batch: what is not given is as in `globals`, and the options that say where
/// the daemon is are not allowed. Throws UsageError.
Command parse_batch_command(const std::vector<std::string>& words, const Globals& globals);

/// What may stand in place of the last of these words, one a line (text/completion.h).
std::string complete_command(const std::vector<std::string_view>& words);

}  // namespace cansync::cli
