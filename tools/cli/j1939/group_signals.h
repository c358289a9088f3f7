#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dbc/database.h"
#include "j1939/client/message_client.h"

/// Signals of J1939 by name: groups of a DBC file, whose identifiers stand for any priority, source and
/// destination. Main thread.
namespace cansync::cli {

/// The message of a group: of several that of this source, else that of address 254, which stands for any,
/// else the first; null: there is none.
const dbc::Message* find_group(const dbc::Database& database, std::uint32_t pgn, std::uint8_t source);

/// As dbc::read_signals; what says "not available" or "error" (SAE J1939-71) and has no other name is named
/// so.
std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data);

/// A message of the file by name, with signals "NAME=VALUE", a number in the signal's unit or the name of a
/// value; all bits that no signal gives are 1, "not available". Of a group for one destination that is all.
/// Throws UsageError.
j1939::client::Message encode_group(const dbc::Database& database, const std::string& name,
                                    std::span<const std::string> settings);

}  // namespace cansync::cli
