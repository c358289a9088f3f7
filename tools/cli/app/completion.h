#pragma once

#include "text/completion.h"

namespace cansync::cli {

/// What the arguments of `cansync` may be. Names of slaves and values come from the running daemon, which is
/// looked for no longer than half a second; without one only their fixed spellings are offered. Never throws;
/// if DDS itself hangs, SIGALRM ends the program after 2 s. Main thread only.
text::CandidateLookup completion_lookup();

}  // namespace cansync::cli
