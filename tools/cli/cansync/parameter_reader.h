#pragma once

#include <functional>
#include <vector>

#include "cli/base/session.h"
#include "profile/profile.h"

namespace cansync::cli {

using Parameters = std::vector<const profile::Parameter*>;

/// Most parameter jobs that one run of the program has open: enough that the line is never waited for, and
/// few beside the daemon's queue, so that other programs have their turn.
inline constexpr std::size_t kOpenJobs = 4;

/// Reads these parameters of a slave in their order, with at most `kOpenJobs` open at once, and gives each
/// reply to `taken`. Ends early at what would go wrong with the others too: no answer, a lost slave, a
/// refusal, Ctrl-C; returns that reply, else one that says done. A slave's error code is no reason to end.
client::Reply read_parameters(
    Session& session, unsigned slave, const Parameters& parameters,
    const std::function<void(const profile::Parameter&, const client::ParameterReply&)>& taken);

}  // namespace cansync::cli
