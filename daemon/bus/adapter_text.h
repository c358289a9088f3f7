#pragma once

#include <string>

#include "can/link_facts.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// That the interface has another adapter than bus.adapter allows: both, and the remedy. Pure; not for the
/// realtime thread (it allocates).
std::string wrong_adapter_text(const BusConfig& bus, const can::LinkFacts& facts);

}  // namespace cansyncd
