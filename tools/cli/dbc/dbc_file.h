#pragma once

#include <span>
#include <string>

#include "dbc/database.h"
#include "text/json.h"

/// DBC files on the command line: what messages mean. Main thread.
namespace cansync::cli {

/// Reads a DBC file. Throws UsageError with each line that is wrong, std::system_error when it cannot be
/// read.
dbc::Database load_dbc(const std::string& path);

/// "Motor: Speed 12.5 rpm, Mode 1 (run)".
std::string meaning_of(const dbc::Message& message, std::span<const dbc::Reading> readings);

/// `message`, null when there is none, and `signals` with name, raw value, value, unit and name of the value.
void add_meaning(const dbc::Message* message, std::span<const dbc::Reading> readings,
                 text::JsonObject& object);

}  // namespace cansync::cli
