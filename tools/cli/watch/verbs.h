#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_watch_verb(CLI::App& app, Verb& chosen);  ///< watch

}  // namespace cansync::cli
