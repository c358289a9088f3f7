#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// The verb `can`, which controls the module of general frames, and which the others are added to.
CLI::App& add_can_verb(CLI::App& app, Verb& chosen);

}  // namespace cansync::cli
