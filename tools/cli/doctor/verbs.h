#pragma once

#include <span>

#include "cli/base/protocol_verbs.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

/// doctor; `protocols`: what each adds, for as long as the program runs.
void add_doctor_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols);

}  // namespace cansync::cli
