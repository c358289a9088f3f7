#include "dds/loopback.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "dds/entity.h"

namespace gateway::dds {
namespace {

/// Port of a UDP socket that listens on every address; nothing for other descriptors.
std::optional<std::uint32_t> open_port(int descriptor) {
  int type = 0;
  socklen_t size = sizeof type;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM)
    return std::nullopt;
  sockaddr_in address = {};
  size = sizeof address;
  // The socket interface gives every kind of address through this type.
  if (::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return std::nullopt;
  if (address.sin_family != AF_INET || address.sin_addr.s_addr != htonl(INADDR_ANY)) return std::nullopt;
  return ntohs(address.sin_port);
}

}  // namespace

void keep_to_loopback(std::uint32_t first_port, std::uint32_t ports) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename().string();
    int descriptor = -1;
    if (std::from_chars(name.data(), name.data() + name.size(), descriptor).ec != std::errc()) continue;
    const auto port = open_port(descriptor);
    if (!port || *port < first_port || *port >= first_port + ports) continue;
    constexpr char kDevice[] = "lo";
    if (::setsockopt(descriptor, SOL_SOCKET, SO_BINDTODEVICE, kDevice, sizeof kDevice) != 0) {
      throw SetupError(
          fmt::format("DDS cannot be kept to interface lo: port {}: {}; a kernel from 5.7 on does it for "
                      "every user",
                      *port, std::generic_category().message(errno)));
    }
  }
  if (error) throw SetupError("DDS cannot be kept to interface lo: /proc/self/fd: " + error.message());
}

}  // namespace gateway::dds
