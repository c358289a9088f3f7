#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can timers` and `can queues`, added to `can`.
void add_timers_verb(CLI::App& can, Verb& chosen);
void add_queues_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
