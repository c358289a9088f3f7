#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// The verbs `can`, which controls the module of general frames, and `timers`.
void add_control_verbs(CLI::App& app, Verb& chosen);

}  // namespace cansync::cli
