#pragma once

#include "cli/base/verbs.h"

namespace cansync::cli {

void add_doctor_verb(CLI::App& app, Verb& chosen);  ///< doctor

}  // namespace cansync::cli
