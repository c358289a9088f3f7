#pragma once

#include <filesystem>

#include "cli/base/exit_codes.h"
#include "cli/base/session.h"
#include "cli/setup/setup_plan.h"

/// `cansync setup --appliance`: the settings of a PC that runs a machine (docs/operations.md). Each is a file
/// of ours beside those of the administrator, so that removing the files undoes everything.
namespace cansync::cli {

struct ApplianceTexts {
  bool undo = false;  ///< remove what was written
  bool dry_run = false;
  bool yes = false;
  std::filesystem::path root = "/";  ///< before every path
};

/// Writes the files, or with `undo` removes those that are there and unchanged.
SetupPlan appliance_plan(const std::filesystem::path& root, bool undo);

/// Asks, carries the plan out, and names each file. A file that somebody has changed is neither written over
/// nor removed: exit code 1, the others are done. Throws UsageError where no question can be asked, and
/// std::system_error with the name of a file that cannot be written.
ExitCode set_up_appliance(Session& session, const ApplianceTexts& texts);

}  // namespace cansync::cli
