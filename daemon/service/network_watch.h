#pragma once

#include <functional>
#include <string>
#include <vector>

#include "daemon/service/surroundings.h"

namespace cansyncd {

/// A network interface as the kernel knows it.
struct NetworkLink {
  unsigned index = 0;  ///< 0: there is none of this name
  bool up = false;
  std::vector<std::string> addresses;  ///< IPv4, in the kernel's order
  friend bool operator==(const NetworkLink&, const NetworkLink&) = default;
};

/// Asks the kernel, over netlink. What it does not say is left as nothing.
NetworkLink kernel_network_link(const std::string& interface);

/// Decides where DDS is: on the interface that is configured while that one can be used, else on `lo`, where
/// the clients of this computer are served. An interface that comes and goes is followed when two looks have
/// found it alike. Main thread.
class NetworkWatch {
 public:
  using Source = std::function<NetworkLink(const std::string& interface)>;

  /// `interface`: as configured; one that need not be followed (`lo`) is never asked for. Looks once.
  explicit NetworkWatch(std::string interface, Source source = kernel_network_link);

  /// Looks. True: `place` is another one now.
  bool look();

  const NetworkPlace& place() const noexcept { return place_; }

 private:
  NetworkPlace place_of(const NetworkLink& link) const;

  const std::string interface_;
  const Source source_;
  NetworkLink seen_;  ///< by the newest look
  NetworkPlace place_;
};

}  // namespace cansyncd
