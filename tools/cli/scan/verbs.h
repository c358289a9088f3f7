#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_scan_verb(CLI::App& app, Verb& chosen);  ///< scan

}  // namespace cansync::cli
