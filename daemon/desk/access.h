#pragma once

#include <cstdint>

#include "dds/denial.h"

/// What a request is allowed to do. Pure functions; any thread.
namespace cansyncd {

/// Who may give a request, with DDS Security on. Each includes those before it.
enum class Right : std::uint8_t {
  operate,   ///< operators: what runs a line that is set up, e.g. control words, and cancelling
  engineer,  ///< engineers: what sets it up, e.g. parameters, transfers, modes
};

/// What a request needs and does.
struct Effect {
  Right right = Right::engineer;  ///< the least it needs
  bool changes = true;            ///< it would change a drive, the line or the master
};

/// Why a request with this effect is not taken because the daemon is read-only (access.read_only); nothing
/// when it may be taken.
gateway::dds::Problem read_only_refusal(const Effect& effect, bool read_only);

}  // namespace cansyncd
