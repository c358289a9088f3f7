#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "dbc/database.h"

namespace signals {

/// Reads the content of a file of signals: a table when the file's name ends in .toml, else a DBC file. Else
/// a text of what is wrong: a line for each problem, with file, line and column. Allocates; any thread.
std::variant<dbc::Database, std::string> read_signal_file(std::string_view content, const std::string& file);

}  // namespace signals
