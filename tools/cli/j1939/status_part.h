#pragma once

#include "cli/base/status_part.h"

namespace cansync::cli {

/// What `status` shows of a bus of J1939.
extern const StatusPart kJ1939StatusPart;

}  // namespace cansync::cli
