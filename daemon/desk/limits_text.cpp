#include "daemon/desk/limits_text.h"

#include <fmt/format.h>

namespace cansyncd {

using gateway::dds::Denial;

Denial too_many_clients(std::size_t clients, std::size_t most) {
  return {gateway_CAUSE_SHARED_LIMIT,
          fmt::format("too many clients: {}, at most {} are allowed; try again when another has ended",
                      clients, most)};
}

Denial too_many_requests(std::size_t open, std::size_t most) {
  return {gateway_CAUSE_CLIENT_LIMIT,
          fmt::format(
              "queue full: this client has {} requests open, at most {} are allowed; wait for a reply first",
              open, most)};
}

Denial too_many_bytes_of_client(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return {gateway_CAUSE_CLIENT_LIMIT,
          fmt::format(
              "length {}: open transfers of this client have {} bytes, at most {} are allowed; wait for a "
              "reply first",
              bytes, open_bytes, most)};
}

Denial too_many_bytes(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return {
      gateway_CAUSE_SHARED_LIMIT,
      fmt::format("length {}: open transfers have {} bytes, at most {} are allowed together; try again later",
                  bytes, open_bytes, most)};
}

}  // namespace cansyncd
