#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "dbc/database.h"
#include "j1939/client/message_client.h"

/// Signals of J1939 by name, into bytes. Main thread.
namespace cansync::cli {

/// A message of the file by name, with signals "NAME=VALUE", a number in the signal's unit or the name of a
/// value, or "not available" or "error" (SAE J1939-71), which no number says; all bits that no signal gives are 1, "not
/// available". It is for whom the file says, or for all. Throws UsageError.
j1939::client::Message encode_group(const dbc::Database& database, const std::string& name,
                                    std::span<const std::string> settings);

}  // namespace cansync::cli
