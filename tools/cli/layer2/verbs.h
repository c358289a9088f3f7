#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `frames` and `send`: a bus of general frames.
void add_layer2_verbs(CLI::App& app, Verb& chosen);

}  // namespace cansync::cli
