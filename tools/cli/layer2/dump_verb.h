#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can dump`, added to `can`: the frames that the daemon receives, or of a recording.
void add_dump_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
