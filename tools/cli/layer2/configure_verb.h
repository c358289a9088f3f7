#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can configure`, which changes the configuration of a daemon that runs, added to `can`.
void add_configure_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
