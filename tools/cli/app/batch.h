#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_batch_verb(CLI::App& app, Verb& chosen);  ///< batch

}  // namespace cansync::cli
