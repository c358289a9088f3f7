#pragma once

#include <span>

#include "cli/base/protocol_verbs.h"
#include "cli/base/verbs.h"

namespace cansync::cli {

void add_event_verb(CLI::App& app, Verb& chosen);  ///< events
void add_wait_verb(CLI::App& app, Verb& chosen);   ///< wait

/// status; `protocols`: what each adds, for as long as the program runs.
void add_status_verb(CLI::App& app, Verb& chosen, std::span<const ProtocolVerbs* const> protocols);

}  // namespace cansync::cli
