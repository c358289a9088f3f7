#pragma once

#include "cli/base/protocol_verbs.h"

namespace cansync::cli {

/// `references`, `actual` and `serve`: the bus of a slave.
extern const ProtocolVerbs cansync_slave_verbs;

void add_actual_verb(CLI::App& app, Verb& chosen);  ///< actual
void add_serve_verb(CLI::App& app, Verb& chosen);   ///< serve

}  // namespace cansync::cli
