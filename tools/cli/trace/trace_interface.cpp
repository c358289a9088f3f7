// Frames of a SocketCAN interface, as they come. Nothing is ever written to the socket.
#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>

#include "can/adapter/link_remedy.h"
#include "can/candump.h"
#include "can/link_kernel.h"
#include "can/socketcan/kernel_frame.h"
#include "cansync/telegram/telegram.h"
#include "cli/trace/trace_source.h"
#include "system/descriptor.h"

namespace cansync::cli {
namespace {

constexpr int kLongestPollMs = 50;

std::string system_text(int error) {
  return std::generic_category().message(error);
}

class InterfaceSource final : public TraceSource {
 public:
  InterfaceSource(const std::string& name, std::uint32_t sync, HeardFrames frames)
      : name_(name), socket_(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW)) {
    if (socket_.number() < 0)
      throw std::runtime_error(
          fmt::format("{}: this kernel has no CAN sockets ({}); `modprobe can_raw` loads them", name,
                      system_text(errno)));
    const unsigned index = ::if_nametoindex(name.c_str());
    if (index == 0)
      throw std::runtime_error(
          fmt::format("{}: neither a file nor a network interface; `ip -br link show type can` lists the CAN "
                      "interfaces, `ip link add dev {} type vcan` makes a virtual one to try",
                      name, name));
    set_filters(sync, frames);
    const int on = 1;
    set(SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);
    set(SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(index);
    if (::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      throw std::runtime_error(fmt::format(
          "{}: not a CAN interface ({}); `ip -br link show type can` lists them", name, system_text(errno)));
  }

  bool endless() const noexcept override { return true; }

  TraceItem next() override {
    pollfd ready{socket_.number(), POLLIN, 0};
    if (::poll(&ready, 1, kLongestPollMs) <= 0) return TraceNothing{};
    can_frame raw{};
    iovec part{&raw, sizeof raw};
    alignas(cmsghdr) std::array<char, 256> control{};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t got = ::recvmsg(socket_.number(), &message, 0);
    if (got < 0) return failed(errno);
    if (got != static_cast<ssize_t>(sizeof raw)) return TraceProblem{"a frame of another size (CAN FD?)"};
    can::CandumpLine line;
    line.interface = name_;
    line.frame = can::from_kernel(raw);
    read_control(message, line);
    return line;
  }

  std::uint64_t dropped() const noexcept override { return dropped_; }

 private:
  void set(int level, int option, const void* value, socklen_t size) {
    if (::setsockopt(socket_.number(), level, option, value, size) != 0)
      throw std::system_error(errno, std::generic_category(), name_);
  }

  void set_filters(std::uint32_t sync, HeardFrames frames) {
    const auto exact = [](std::uint32_t id) { return can::to_kernel(can::FrameFilter{.identifier = id}); };
    const auto channel = [](std::uint32_t id) {
      return can::to_kernel(can::FrameFilter{.identifier = id, .mask = ~0x7Fu});
    };
    const std::array filters{exact(identifier::action),          exact(sync),
                             channel(identifier::reference_one), channel(identifier::reference_two),
                             channel(identifier::actual_one),    channel(identifier::actual_two),
                             channel(identifier::command),       channel(identifier::response)};
    // A new socket takes every frame.
    if (frames == HeardFrames::telegrams) set(SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), sizeof filters);
    const can_err_mask_t errors = CAN_ERR_MASK;
    set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors);
  }

  TraceItem failed(int error) const {
    if (error == EAGAIN || error == EINTR) return TraceNothing{};
    if (error == ENETDOWN)
      return TraceRemark{fmt::format("{} is down; remedy: {}", name_,
                                     can::link_remedy(name_, can::make_link_kernel()->read(name_)))};
    throw std::system_error(error, std::generic_category(), name_);
  }

  void read_control(msghdr& message, can::CandumpLine& line) {
    for (cmsghdr* part = CMSG_FIRSTHDR(&message); part != nullptr; part = CMSG_NXTHDR(&message, part)) {
      if (part->cmsg_level != SOL_SOCKET) continue;
      if (part->cmsg_type == SO_TIMESTAMP) {
        timeval time{};
        std::memcpy(&time, CMSG_DATA(part), sizeof time);
        line.time = std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_usec);
      } else if (part->cmsg_type == SO_RXQ_OVFL) {
        std::uint32_t count = 0;
        std::memcpy(&count, CMSG_DATA(part), sizeof count);
        dropped_ = count;
      }
    }
  }

  std::string name_;
  sys::Descriptor socket_;
  std::uint64_t dropped_ = 0;
};

}  // namespace

std::unique_ptr<TraceSource> open_interface(const std::string& name, std::uint32_t sync, HeardFrames frames) {
  return std::make_unique<InterfaceSource>(name, sync, frames);
}

}  // namespace cansync::cli
