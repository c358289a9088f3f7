#pragma once

#include <cstdint>
#include <string>

#include "can/link_facts.h"

namespace can {

/// What brings up an interface that is down or missing, by its kind: a command, with what it needs to know. A virtual interface
/// (vcan, vxcan) has no bit rate, one on a serial line (slcan) has that of slcand, an adapter has its own. `link`: what the kernel
/// knows; of one that is missing its name says the kind. `bit_rate`: of the bus, in bit/s; 0: not known. Allocates.
std::string link_remedy(const std::string& name, const LinkFacts& link, std::uint32_t bit_rate = 0);

/// Commands that end the listen-only mode of an interface and set it up. Allocates.
std::string sending_remedy(const std::string& name);

}  // namespace can
