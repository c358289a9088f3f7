#include "dds/reply_partition.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace gateway::dds {

std::string reply_partition(std::string_view bus, const std::array<std::uint8_t, 16>& client) {
  return fmt::format("{}/{:02x}", bus, fmt::join(client, ""));
}

std::string reply_writer_partition(std::string_view bus, const std::array<std::uint8_t, 16>& client) {
  return reply_partition(bus, client) + "*";
}

std::string every_reply_partition(std::string_view bus) {
  return fmt::format("{}/*", bus);
}

}  // namespace gateway::dds
