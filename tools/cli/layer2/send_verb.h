#pragma once

#include <CLI/CLI.hpp>

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `can send`, added to `can`: frames to be sent.
void add_send_verb(CLI::App& can, Verb& chosen);

}  // namespace cansync::cli
