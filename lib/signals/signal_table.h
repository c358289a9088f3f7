#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/problem.h"
#include "dbc/database.h"

/// Messages and signals by name, as a table in TOML describes them: what a DBC file says, for people who
/// write it by hand. Allocates; main thread.
namespace signals {

/// Reads a table: [[message]] with name, identifier or pgn, extended, length; [[signal]] with message, name,
/// start, length and more (docs/signals.md). `file` is what positions name. Problems: in the order of the
/// file.
std::variant<dbc::Database, std::vector<config::Problem>> read_signal_table(std::string_view toml,
                                                                            const std::string& file);

}  // namespace signals
