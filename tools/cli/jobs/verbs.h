#pragma once

#include <span>

#include "cli/base/protocol_verbs.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

void add_job_verbs(CLI::App& app, Verb& chosen);  ///< jobs, cancel, clients

/// buses; `protocols`: what each says of its bus, for as long as the program runs.
void add_buses_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols);

}  // namespace cansync::cli
