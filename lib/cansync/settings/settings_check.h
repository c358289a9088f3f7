#pragma once

#include <string>
#include <vector>

#include "cansync/settings/settings.h"

namespace cansync {

/// One setting that no master may start with.
struct SettingProblem {
  std::string field;    ///< path in `MasterSettings`, e.g. "slaves[3].block_limit"
  std::string found;    ///< its value in words
  std::string allowed;  ///< what would be right, with the unit
};

/// Everything that is wrong with `settings`, in the order of the struct; empty: a master may be built from
/// them. For set-up code on a normal thread: allocates, not for the realtime thread.
std::vector<SettingProblem> check(const MasterSettings& settings);

}  // namespace cansync
