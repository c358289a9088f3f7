#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

/// Where replies go: each client has a DDS partition of its own for its readers of replies, so that what is
/// sent to one does not reach the others. It keeps traffic apart; it is no secret.
namespace gateway::dds {

/// "BUS/" and the client's identity in 32 hexadecimal digits, in lower case.
std::string reply_partition(std::string_view bus, const std::array<std::uint8_t, 16>& client);

/// Where the daemon writes what is for this client alone: a pattern that fits the client's own partition. DDS matches no
/// pattern with a pattern (DDS 1.4, 2.2.3.13), so readers of "BUS/*", which might acknowledge nothing, hold no reply up.
std::string reply_writer_partition(std::string_view bus, const std::array<std::uint8_t, 16>& client);

/// The partitions of all clients of a bus: for what only wants to know of their readers.
std::string every_reply_partition(std::string_view bus);

}  // namespace gateway::dds
