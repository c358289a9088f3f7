#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "config/problem.h"
#include "dbc/database.h"

/// Messages and signals by name, as a table in TOML describes them: what a DBC file says, for people who
/// write it by hand. Allocates; main thread.
namespace signals {

/// What of a table can be used, and what was left out.
struct SignalTable {
  dbc::Database database;
  std::vector<config::Problem> problems;  ///< in the order of the file
};

/// Reads a table: [[message]] with name, identifier or pgn, extended, length; [[signal]] with message, name,
/// start, length and more (docs/signals.md). `file` is what positions name. A message or signal with a problem
/// is left out whole, and so are the signals of such a message and those that such a signal chooses.
SignalTable read_signal_table(std::string_view toml, const std::string& file);

}  // namespace signals
