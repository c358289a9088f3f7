#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can script`, added to `can`: a script is checked or run.
void add_script_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
