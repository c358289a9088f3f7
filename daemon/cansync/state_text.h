#pragma once

#include <string>

#include "daemon/cansync/exchange.h"

namespace cansyncd {

/// The master's operating state in words, or what keeps it from sending: another master on the bus, a command
/// that it waits for, that it still listens, or that the upper bus of its cluster has no SYNC. At most 63 characters.
std::string state_text(const MasterSnapshot& master);

/// "identifier 0x105", or "a SYNC frame" for identifier 0.
std::string other_master_frame(std::uint32_t identifier);

}  // namespace cansyncd
