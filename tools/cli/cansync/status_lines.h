#pragma once

#include <vector>

#include "cli/base/status_part.h"

namespace cansync::cli {

/// What `status` shows of a line of CANsync.
extern const StatusPart kMasterStatusPart;

/// Its lines of one sample.
std::vector<Explained> master_lines(const client::MasterStatus& status);

/// Without SYNC nobody is asked: what was known of the slaves is past.
bool asks_slaves(const client::MasterStatus& master);

}  // namespace cansync::cli
