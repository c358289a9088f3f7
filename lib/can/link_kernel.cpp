#include "can/link_kernel.h"

#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <span>
#include <system_error>

#include "can/adapter/adapters.h"
#include "system/descriptor.h"

namespace can {
namespace {

int open_or_throw(int descriptor, const char* what) {
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), what);
  return descriptor;
}

/// A request about one interface, built attribute by attribute.
class LinkRequest {
 public:
  LinkRequest(std::uint16_t type, std::uint16_t flags) noexcept {
    header().nlmsg_type = type;
    header().nlmsg_flags = static_cast<std::uint16_t>(NLM_F_REQUEST | flags);
    header().nlmsg_len = NLMSG_LENGTH(sizeof(ifinfomsg));
  }
  nlmsghdr& header() noexcept { return *reinterpret_cast<nlmsghdr*>(bytes_.data()); }
  ifinfomsg& link() noexcept { return *reinterpret_cast<ifinfomsg*>(bytes_.data() + NLMSG_HDRLEN); }
  std::span<const std::byte> bytes() noexcept { return {bytes_.data(), header().nlmsg_len}; }

  /// Adds an attribute and returns where it begins.
  std::size_t add(std::uint16_t type, const void* payload, std::size_t size) noexcept {
    const std::size_t at = NLMSG_ALIGN(header().nlmsg_len);
    const rtattr attribute{static_cast<std::uint16_t>(RTA_LENGTH(size)), type};
    std::memcpy(bytes_.data() + at, &attribute, sizeof(attribute));
    if (size != 0) std::memcpy(bytes_.data() + at + RTA_LENGTH(0), payload, size);
    header().nlmsg_len = static_cast<std::uint32_t>(at + RTA_LENGTH(size));
    return at;
  }
  /// Everything added since `at` belongs into that attribute.
  void enclose(std::size_t at) noexcept {
    const auto length = static_cast<std::uint16_t>(header().nlmsg_len - at);
    std::memcpy(bytes_.data() + at, &length, sizeof(length));
  }

 private:
  // Requests are far smaller: a name or two numbers.
  alignas(nlmsghdr) std::array<std::byte, 256> bytes_ = {};
};

class NetlinkKernel final : public LinkKernel {
 public:
  NetlinkKernel()
      : requests_(
            open_or_throw(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE), "netlink socket")),
        changes_(open_or_throw(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE),
                               "netlink socket")),
        interrupt_(open_or_throw(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")) {
    const timeval most{1, 0};
    ::setsockopt(requests_.number(), SOL_SOCKET, SO_RCVTIMEO, &most, sizeof(most));
    sockaddr_nl address{};
    address.nl_family = AF_NETLINK;
    address.nl_groups = RTMGRP_LINK;
    if (::bind(changes_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::system_error(errno, std::generic_category(), "netlink: watching the interfaces");
    }
  }

  LinkFacts read(const std::string& name) noexcept override {
    LinkRequest request(RTM_GETLINK, 0);
    request.add(IFLA_IFNAME, name.c_str(), std::min<std::size_t>(name.size(), IFNAMSIZ - 1) + 1);
    const std::uint32_t filter = RTEXT_FILTER_SKIP_STATS;
    request.add(IFLA_EXT_MASK, &filter, sizeof(filter));
    int error = 0;
    const auto answer = ask(request, error);
    LinkFacts facts = read_link_message(answer, name).value_or(LinkFacts{});
    if (facts.is_can) facts.adapter = adapter(name, facts.index);
    return facts;
  }

  void wait(std::chrono::milliseconds most) noexcept override {
    std::array<pollfd, 2> watched{{{changes_.number(), POLLIN, 0}, {interrupt_.number(), POLLIN, 0}}};
    if (::poll(watched.data(), watched.size(), static_cast<int>(most.count())) <= 0) return;
    // What has changed is read afresh; the messages only say that something has.
    while (::recv(changes_.number(), answer_.data(), answer_.size(), 0) > 0 || errno == ENOBUFS) {
    }
    std::uint64_t count = 0;
    static_cast<void>(!::read(interrupt_.number(), &count, sizeof(count)));
  }

  void interrupt() noexcept override {
    const std::uint64_t one = 1;
    // Fails only when it is signalled already.
    static_cast<void>(!::write(interrupt_.number(), &one, sizeof(one)));
  }

  int restart(std::uint32_t index) noexcept override {
    LinkRequest request(RTM_NEWLINK, NLM_F_ACK);
    request.link().ifi_index = static_cast<int>(index);
    const std::size_t info = request.add(IFLA_LINKINFO, nullptr, 0);
    request.add(IFLA_INFO_KIND, "can", 3);
    const std::size_t data = request.add(IFLA_INFO_DATA, nullptr, 0);
    const std::uint32_t now = 1;
    request.add(IFLA_CAN_RESTART, &now, sizeof(now));
    request.enclose(data);
    request.enclose(info);
    return change(request);
  }

  int set_up(std::uint32_t index, bool up) noexcept override {
    LinkRequest request(RTM_NEWLINK, NLM_F_ACK);
    request.link().ifi_index = static_cast<int>(index);
    request.link().ifi_change = IFF_UP;
    request.link().ifi_flags = up ? IFF_UP : 0;
    return change(request);
  }

 private:
  /// Read from sysfs once for each interface that comes: an index is not used for two.
  const Adapter& adapter(const std::string& name, std::uint32_t index) noexcept {
    if (index != adapter_index_ || !adapter_.known()) adapter_ = adapter_of(name, index);
    adapter_index_ = index;
    return adapter_;
  }

  int change(LinkRequest& request) noexcept {
    int error = 0;
    ask(request, error);
    return error;
  }

  /// Sends a request and returns its answer; empty, and the error (0: acknowledged), when it is none.
  std::span<const std::byte> ask(LinkRequest& request, int& error) noexcept {
    request.header().nlmsg_seq = ++sequence_;
    const auto bytes = request.bytes();
    if (::send(requests_.number(), bytes.data(), bytes.size(), 0) < 0) {
      error = -errno;
      return {};
    }
    // An answer to an earlier request that came too late is passed over; there are few of them.
    for (unsigned tries = 0; tries < 8; ++tries) {
      const ssize_t size = ::recv(requests_.number(), answer_.data(), answer_.size(), 0);
      if (size < 0 && errno == EINTR) continue;
      if (size < static_cast<ssize_t>(sizeof(nlmsghdr))) break;
      nlmsghdr header;
      std::memcpy(&header, answer_.data(), sizeof(header));
      if (header.nlmsg_seq != sequence_) continue;
      if (header.nlmsg_type != NLMSG_ERROR) return {answer_.data(), static_cast<std::size_t>(size)};
      nlmsgerr told{};
      if (size < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(told)))) break;
      std::memcpy(&told, answer_.data() + NLMSG_HDRLEN, sizeof(told));
      error = told.error;
      return {};
    }
    error = -ETIMEDOUT;
    return {};
  }

  sys::Descriptor requests_;
  sys::Descriptor changes_;
  sys::Descriptor interrupt_;
  std::uint32_t sequence_ = 0;
  std::uint32_t adapter_index_ = 0;  ///< interface that `adapter_` is that of
  Adapter adapter_;
  alignas(nlmsghdr) std::array<std::byte, 32768> answer_ = {};
};

}  // namespace

std::unique_ptr<LinkKernel> make_link_kernel() {
  return std::make_unique<NetlinkKernel>();
}

}  // namespace can
