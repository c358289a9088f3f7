#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_learn_verb(CLI::App& app, Verb& chosen);  ///< learn

}  // namespace cansync::cli
