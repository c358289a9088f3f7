#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// None of its own: the buses of a cluster are those of a slave and of a master.
extern const ProtocolVerbs cansync_cluster_verbs;

}  // namespace cansync::cli
