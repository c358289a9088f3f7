#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "cli/base/session.h"

namespace cansync::cli {

/// What a verb of the command line does; the exit code says how it ended.
using Verb = std::function<ExitCode(Session&)>;

/// Adds verbs to the program; the one that was named on the command line puts what is to be done into
/// `chosen`, which is called once after parsing. Every room with verbs has functions of this kind in its
/// verbs.h.
using AddVerbs = void (*)(CLI::App& app, Verb& chosen);

}  // namespace cansync::cli
