#pragma once

#include <vector>

#include "cli/base/status_part.h"

namespace cansync::cli {

/// What `status` shows of a line of CANsync.
extern const StatusPart kMasterStatusPart;

/// Its lines of one sample.
std::vector<Explained> master_lines(const client::MasterStatus& status);

}  // namespace cansync::cli
