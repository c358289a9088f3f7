#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "dbc/database.h"

namespace signals {

/// What could be read of a file.
struct SignalFile {
  dbc::Database database;
  std::vector<std::string> remarks;  ///< "FILE:LINE:COLUMN: what was left out, or taken otherwise, and why"
  std::size_t more_remarks = 0;      ///< that are not kept
};

/// Reads the content of a file of signals: a table when the file's name ends in .toml, else a DBC file. What is
/// not understood is left out with a remark; a file without any message is refused: then a text of what is
/// wrong. Allocates; any thread.
std::variant<SignalFile, std::string> read_signal_file(std::string_view content, const std::string& file);

}  // namespace signals
