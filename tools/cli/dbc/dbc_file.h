#pragma once

#include <CLI/App.hpp>
#include <span>
#include <string>

#include "cli/base/output.h"
#include "dbc/database.h"
#include "text/json.h"

/// Files of signals on the command line: what messages mean. Main thread.
namespace cansync::cli {

/// Reads a DBC file, or, when its name ends in .toml, a table of signals (docs/signals.md). What is left out is
/// shown (`tell_left_out`). Throws UsageError when nothing can be used, std::system_error when the file cannot be
/// read.
dbc::Database load_signals(const std::string& path, Output& output);

/// The options --dbc and --signals of a verb, which both give such a file; `what` begins their help.
void add_signal_files(CLI::App& verb, std::string& path, const std::string& what);

/// "Motor: Speed 12.5 rpm, Mode 1 (run), Heat not available (0xFF)". `others`: messages of its group that it could be
/// as well.
std::string meaning_of(const dbc::Message& message, std::span<const dbc::Reading> readings,
                       std::size_t others = 0);

/// `message`, null when there is none, and `signals` with name, raw value, value, unit and name of the value.
void add_meaning(const dbc::Message* message, std::span<const dbc::Reading> readings,
                 text::JsonObject& object);

}  // namespace cansync::cli
