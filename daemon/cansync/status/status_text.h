#pragma once

#include <string>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"

namespace cansyncd {

/// The line in one sentence, for `systemctl status`: what keeps it from running first, else operating state,
/// how many of the configured slaves respond, who does not, bus and bit rate. Pure; allocates.
std::string status_text(const MasterSnapshot& master, const Config& config);

}  // namespace cansyncd
