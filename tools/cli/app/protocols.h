#pragma once

#include <span>

#include "cli/base/status_part.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

/// What adds the verbs of each protocol that the command line knows: its only list of protocols.
std::span<const AddVerbs> protocol_verbs() noexcept;

/// What each of them adds to `status`.
std::span<const StatusPart> protocol_status() noexcept;

}  // namespace cansync::cli
