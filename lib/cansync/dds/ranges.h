#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cansync/dds/validate.h"
#include "cansync/telegram/numbers.h"
#include "dds/denial.h"

/// Building blocks of the checks in validate.cpp and validate_command.cpp; internal to lib/dds.
namespace cansync::dds {

using gateway::dds::Problem;

/// Of a field: "field 33: out of range; allowed 0..31" unless `minimum` <= value <= `maximum`.
Problem in_range(std::string_view field, std::int64_t value, std::int64_t minimum, std::int64_t maximum);

/// "0..3, 7" for a mask; "none" for the empty one.
std::string list_of(SlaveMask slaves);

/// A slave number 0..31 that is configured.
Problem configured_slave(std::string_view field, std::uint32_t slave, const Limits& limits);

/// Monitoring time in milliseconds.
Problem timeout_in_range(std::uint32_t timeout);

}  // namespace cansync::dds
