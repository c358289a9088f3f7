#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

/// `references`: the bus of a slave.
void add_slave_role_verbs(CLI::App& app, Verb& chosen);

}  // namespace cansync::cli
