#pragma once

#include "cli/base/status_part.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

/// What a protocol adds to the command line.
struct ProtocolVerbs {
  AddVerbs add;              ///< its verbs
  const StatusPart* status;  ///< what `status` shows of it; null: nothing, its buses are of other protocols
};

}  // namespace cansync::cli
