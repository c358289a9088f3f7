#pragma once

#include "cli/base/status_part.h"

namespace cansync::cli {

/// What `status` shows of a bus of general frames.
extern const StatusPart kFrameStatusPart;

}  // namespace cansync::cli
