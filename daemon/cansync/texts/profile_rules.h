#pragma once

#include <cstdint>
#include <string>

#include "cansync.h"
#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"
#include "dds/denial.h"

/// What drive profiles say of requests. Pure functions; any thread; they allocate.
namespace cansyncd {

/// "speed-limit (parameter 401)" of a slave whose profile has it, else "parameter 401".
std::string parameter_label(const Config& config, unsigned slave, std::uint32_t number);

/// The same for a request, whose fields may be out of range; a sub-slave is named and has no profile.
std::string parameter_text(const Config& config, const cansync_ParameterRequest& sample);

/// Why `request` is not taken because of the slave's profile: a write to a parameter that is read-only, with
/// a value outside its limits or wider than its format. Nothing when it may be taken, the slave has no
/// profile, its profile has no such parameter, or access.profile_rules is off.
gateway::dds::Problem profile_refusal(const Request& request, const Config& config);

}  // namespace cansyncd
