#pragma once

#include <cstdint>

namespace gateway::dds {

/// Keeps the UDP sockets of a DDS domain of this process to the interface `lo`: Cyclone sends on the
/// configured interface alone, but listens on every address. Any thread. Throws SetupError when the system
/// does not do it.
void keep_to_loopback(std::uint32_t domain);

}  // namespace gateway::dds
