#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `references` and `actual`: the bus of a slave.
void add_slave_role_verbs(CLI::App& app, Verb& chosen);

void add_actual_verb(CLI::App& app, Verb& chosen);  ///< actual

}  // namespace cansync::cli
