#pragma once

#include <string>
#include <vector>

#include "cansync/config/draft.h"

namespace cansyncd {

/// Checks that concern more than one option: a mapping given in both forms, names used twice, what the master
/// cannot take (cansync::check), files that are not there. A drive profile that is missing or wrong is not
/// among them, but in the draft's `profile_problems`. Turns the mapping drafts into mappings and makes
/// the path of the fault script absolute or relative to the working folder. `path` is the file's.
std::vector<Problem> check_and_finish(Draft& draft, const std::vector<Setting>& settings,
                                      const std::string& path);

}  // namespace cansyncd
