#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can objects`, which shows and uses the 32 message objects, added to `can`.
void add_objects_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
