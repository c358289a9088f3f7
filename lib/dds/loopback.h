#pragma once

#include <cstdint>

namespace gateway::dds {

/// Keeps the UDP sockets of this process at these ports to the interface `lo`: Cyclone sends on the configured
/// interface alone, but listens on every address. Any thread. Throws SetupError when the system does not do
/// it.
void keep_to_loopback(std::uint32_t first_port, std::uint32_t ports);

}  // namespace gateway::dds
