#pragma once

#include <CLI/CLI.hpp>
#include <string_view>

#include "cli/base/session.h"

/// What reaches the whole line at once is not done by a slip of the hand. Main thread only.
namespace cansync::cli {

/// What the command line said to a verb that reaches the whole line.
struct Consent {
  bool yes = false;      ///< it is not to be asked
  bool dry_run = false;  ///< it is only to be said
};

/// Adds --yes and, where the verb has none of its own, --dry-run.
void add_consent_options(CLI::App& verb, Consent& consent);
void add_yes_option(CLI::App& verb, bool& yes);

/// What is the case when nobody can be asked because there is no terminal.
enum class Unasked : unsigned char {
  refused,  ///< UsageError, which says what to add
  done,     ///< it is on the safe side
};

/// Asks on a terminal, where `effect` says what would come of it ("mode stop: the line ..."). Comes back when
/// it is to be done. Throws UsageError without a terminal, Ended when the answer is no, Interrupted at
/// Ctrl-C, ArgumentsAreRight.
void ask_consent(Session& session, const Consent& consent, std::string_view effect,
                 Unasked unasked = Unasked::refused);

/// "bus can0 (process 12 on host plc7), in run with 4 slaves": what a verb would reach. Throws
/// as `Session::client`.
std::string reached_line(Session& session);

}  // namespace cansync::cli
