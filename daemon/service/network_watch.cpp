#include "daemon/service/network_watch.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <array>
#include <memory>
#include <string_view>
#include <utility>

namespace cansyncd {
namespace {

constexpr const char* kLoopback = "lo";

struct FreeAddresses {
  void operator()(ifaddrs* all) const noexcept { ::freeifaddrs(all); }
};

}  // namespace

NetworkLink kernel_network_link(const std::string& interface) {
  NetworkLink link;
  link.index = ::if_nametoindex(interface.c_str());
  ifaddrs* first = nullptr;
  if (link.index == 0 || ::getifaddrs(&first) != 0) return link;
  const std::unique_ptr<ifaddrs, FreeAddresses> all(first);
  for (const ifaddrs* one = first; one != nullptr; one = one->ifa_next) {
    if (interface != one->ifa_name) continue;
    link.up = (one->ifa_flags & IFF_UP) != 0;
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size()) != nullptr)
      link.addresses.emplace_back(text.data());
  }
  return link;
}

NetworkWatch::NetworkWatch(std::string interface, Source source)
    : interface_(std::move(interface)), source_(std::move(source)) {
  if (interface_ == kLoopback) {
    place_.interface = kLoopback;
    return;
  }
  seen_ = source_(interface_);
  place_ = place_of(seen_);
}

bool NetworkWatch::look() {
  if (interface_ == kLoopback) return false;
  NetworkLink now = source_(interface_);
  const bool steady = now == seen_;
  seen_ = std::move(now);
  if (!steady) return false;
  NetworkPlace place = place_of(seen_);
  if (place == place_) return false;
  place_ = std::move(place);
  return true;
}

NetworkPlace NetworkWatch::place_of(const NetworkLink& link) const {
  const auto local = [&](std::string_view what) {
    return NetworkPlace{
        kLoopback, "",
        fmt::format("network interface '{}' (dds.interface) {}: only clients of this computer are served",
                    interface_, what)};
  };
  if (link.index == 0) return local("does not exist");
  if (!link.up) return local("is down");
  if (link.addresses.empty()) return local("has no IPv4 address");
  return {interface_, fmt::format("{} {}", link.index, fmt::join(link.addresses, " ")), ""};
}

}  // namespace cansyncd
