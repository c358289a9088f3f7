#pragma once

#include <string>

#include "cansync/config/config.h"
#include "cansync/settings/reference_limits.h"
#include "dds/denial.h"

/// Limits of reference values, as text. Not for the realtime thread (allocates).
namespace cansyncd {

/// Why values were refused: the value, the limit and the remedy, in the value's unit.
gateway::dds::Denial limit_denial(const cansync::LimitViolation& beyond, const Config& config);

/// The limits in numbers, e.g. "minimum -100, maximum 100, no max_step, no start_within".
std::string limits_text(const cansync::ReferenceLimits& limits);

}  // namespace cansyncd
