#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "dbc/database.h"

/// Signals of J1939 by name: groups of a file, whose identifiers stand for any priority, source and
/// destination. Allocates; main thread.
namespace j1939::client {

/// The message of a group: of several that of this source, else that of address 254, which stands for any,
/// else the first; null: there is none.
const dbc::Message* find_group(const dbc::Database& database, std::uint32_t pgn, std::uint8_t source);

/// As dbc::read_signals; what says "not available" or "error" (SAE J1939-71) and has no other name is named
/// so.
std::vector<dbc::Reading> read_group(const dbc::Message& message, std::span<const std::uint8_t> data);

}  // namespace j1939::client
