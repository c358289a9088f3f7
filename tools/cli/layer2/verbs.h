#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// `frames`, `send`, `can` and `timers`: a bus of general frames.
extern const ProtocolVerbs layer2_verbs;

}  // namespace cansync::cli
