#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_event_verb(CLI::App& app, Verb& chosen);  ///< events
void add_wait_verb(CLI::App& app, Verb& chosen);   ///< wait

}  // namespace cansync::cli
