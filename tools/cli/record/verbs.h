#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_record_verb(CLI::App& app, Verb& chosen);  ///< record
void add_plot_verb(CLI::App& app, Verb& chosen);    ///< plot

}  // namespace cansync::cli
