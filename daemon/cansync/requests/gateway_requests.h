#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cansync.h"
#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"

/// Commands of clients as requests to the realtime thread, and requests in words for the journal. Pure
/// functions; not for the realtime thread (allocates).
namespace cansyncd {

/// The request a command stands for; nothing for a kind that is not known, or fields that
/// `cansync::dds::check` would refuse.
std::optional<Request> to_request(const cansync_Command& command, cansync::JobId id);

/// What is worth a line in the journal: everything that changes something on the line, e.g. "write slave 3
/// 'feeder' parameter 120 = 500 (0x1F4)". Nothing for reads, uploads and process data.
std::optional<std::string> describe(const Request& request, const Config& config);

/// "automatic", "nobody" or "slave 3".
std::string cursor_text(const cansync::Cursor& cursor);

/// Requests that make the settings in force those of `to`, where `to` differs from `from`: mappings, polling
/// and cursors. They carry JobId 0.
std::vector<Request> changes(const Config& from, const Config& to);

}  // namespace cansyncd
