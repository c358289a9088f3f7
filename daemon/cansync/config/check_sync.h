#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace cansyncd {

/// Something wrong with [sync] that one option alone cannot tell.
struct SyncProblem {
  std::string key;   ///< the option to be changed
  std::string text;  ///< what was found and what is allowed
};

/// Combinations of output and input that make no sense, and a software SYNC identifier that CANsync uses.
/// Main thread.
std::vector<SyncProblem> check_sync(const SyncConfig& sync);

}  // namespace cansyncd
