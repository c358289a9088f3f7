#include "daemon/desk/limits_text.h"

#include <fmt/format.h>

namespace cansyncd {

std::string too_many_clients(std::size_t clients, std::size_t most) {
  return fmt::format("too many clients: {}, at most {} are allowed; try again when another has ended",
                     clients, most);
}

std::string too_many_requests(std::size_t open, std::size_t most) {
  return fmt::format(
      "queue full: this client has {} requests open, at most {} are allowed; wait for a reply first", open,
      most);
}

std::string too_many_bytes_of_client(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return fmt::format(
      "length {}: open transfers of this client have {} bytes, at most {} are allowed; wait for a "
      "reply first",
      bytes, open_bytes, most);
}

std::string too_many_bytes(std::size_t bytes, std::size_t open_bytes, std::size_t most) {
  return fmt::format(
      "length {}: open transfers have {} bytes, at most {} are allowed together; try again later", bytes,
      open_bytes, most);
}

}  // namespace cansyncd
