#pragma once

#include <cstddef>

#include "dds/denial.h"

/// What clients are told when a limit of the desk is reached. Pure functions; they allocate.
namespace cansyncd {

/// Why the gateway has no room for one more client, for one more request of a client, or for the bytes of a
/// transfer: what there is, what is allowed, and when to try again.
gateway::dds::Denial too_many_clients(std::size_t clients, std::size_t most);
gateway::dds::Denial too_many_requests(std::size_t open, std::size_t most);
gateway::dds::Denial too_many_bytes_of_client(std::size_t bytes, std::size_t open_bytes, std::size_t most);
gateway::dds::Denial too_many_bytes(std::size_t bytes, std::size_t open_bytes, std::size_t most);

}  // namespace cansyncd
