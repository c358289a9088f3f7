#include "daemon/desk/limits_text.h"

#include <fmt/format.h>

#include "text/counts.h"

namespace cansyncd {

using gateway::dds::Denial;

Denial too_many_clients(std::size_t clients, std::size_t most) {
  return {gateway_CAUSE_SHARED_LIMIT,
          fmt::format("too many clients: {}, at most {} are allowed; try again when another has ended",
                      clients, most)};
}

Denial too_many_requests(std::size_t open, std::size_t most) {
  return {gateway_CAUSE_CLIENT_LIMIT,
          fmt::format("queue full: this client has {} open, at most {} are allowed; wait for a reply first",
                      text::counted(open, "request"), most)};
}

Denial too_many_bytes_of_client(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return {
      gateway_CAUSE_CLIENT_LIMIT,
      fmt::format(
          "length {}: open transfers of this client have {}, at most {} are allowed; wait for a reply first",
          bytes, text::counted(open_bytes, "byte"), most)};
}

Denial too_many_bytes(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return {gateway_CAUSE_SHARED_LIMIT,
          fmt::format("length {}: open transfers have {}, at most {} are allowed together; try again later",
                      bytes, text::counted(open_bytes, "byte"), most)};
}

}  // namespace cansyncd
