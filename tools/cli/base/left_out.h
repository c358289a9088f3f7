#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "cli/base/exit_codes.h"
#include "cli/base/output.h"

/// What was left out of the files that a verb reads besides its own data: signals, profiles. Main thread.
namespace cansync::cli {

/// Shows what was left out of `file`, each file once in a verb: the first ten remarks, then the count, with --json
/// all. `more`: remarks that are not kept. Nothing to show: does nothing.
void tell_left_out(Output& output, const std::string& file, std::span<const std::string> remarks,
                   std::size_t more = 0);

/// How a verb ends: `code`, but `in_part` when it is `done` and something was told. The next verb begins anew.
ExitCode end_of_verb(ExitCode code);

}  // namespace cansync::cli
