#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// `references` and `actual`: the bus of a slave.
extern const ProtocolVerbs cansync_slave_verbs;

void add_actual_verb(CLI::App& app, Verb& chosen);  ///< actual

}  // namespace cansync::cli
