#pragma once

#include "cli/base/status_part.h"

namespace cansync::cli {

/// What `status` shows of the bus of a slave.
extern const StatusPart kSlaveStatusPart;

}  // namespace cansync::cli
