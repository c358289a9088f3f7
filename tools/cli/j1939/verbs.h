#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// `messages`, `transmit`, `request`, `addresses` and `faults`: a bus of J1939.
extern const ProtocolVerbs j1939_verbs;

}  // namespace cansync::cli
