#pragma once

#include <string>

#include "dbc/database.h"
#include "text/json.h"

/// DBC files on the command line: what frames mean. Main thread.
namespace cansync::cli {

/// Reads a DBC file. Throws UsageError with each line that is wrong, std::system_error when it cannot be
/// read.
dbc::Database load_dbc(const std::string& path);

/// "Motor: Speed 12.5 rpm, Mode 1 (run)"; empty when the file has no such message. A signal whose bits did
/// not come is left out.
std::string meaning_of(const dbc::Database& database, const can::Frame& frame);

/// `message`, null when the file has none, and `signals` with name, raw value, value, unit and name of the
/// value.
void add_meaning(const dbc::Database& database, const can::Frame& frame, text::JsonObject& object);

}  // namespace cansync::cli
