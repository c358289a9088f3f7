#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_setup_verb(CLI::App& app, Verb& chosen);  ///< setup

}  // namespace cansync::cli
