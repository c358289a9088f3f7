#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// `can` and the verbs behind it: a bus of general frames.
extern const ProtocolVerbs layer2_verbs;

}  // namespace cansync::cli
