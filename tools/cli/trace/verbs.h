#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_trace_verb(CLI::App& app, Verb& chosen);  ///< trace

}  // namespace cansync::cli
