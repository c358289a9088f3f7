#pragma once

#include <span>

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// What each protocol adds to the command line; `protocols.def` lists them.
std::span<const ProtocolVerbs* const> protocols() noexcept;

}  // namespace cansync::cli
