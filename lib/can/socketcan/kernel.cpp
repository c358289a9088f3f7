#include "can/socketcan/kernel.h"

#include <linux/can/raw.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>

#include "system/clock.h"

namespace can {
namespace {

int result_of(long returned) noexcept {
  return returned < 0 ? -errno : static_cast<int>(returned);
}

class SystemKernel final : public Kernel {
 public:
  int open_socket() noexcept override {
    return result_of(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  }
  void close_socket(int socket) noexcept override { ::close(socket); }
  int set_option(int socket, int level, int name, const void* value, std::size_t size) noexcept override {
    return result_of(::setsockopt(socket, level, name, value, static_cast<socklen_t>(size)));
  }
  int bind_to(int socket, int interface) noexcept override {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = interface;
    // bind() takes every address family through the one type.
    return result_of(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof(address)));
  }
  int send_frame(int socket, const can_frame& frame) noexcept override {
    return result_of(::send(socket, &frame, sizeof(frame), MSG_DONTWAIT));
  }
  int receive(int socket, mmsghdr* messages, unsigned count) noexcept override {
    return result_of(::recvmmsg(socket, messages, count, MSG_DONTWAIT, nullptr));
  }
  int sleep_until(Time deadline) noexcept override {
    const timespec wake = sys::to_timespec(deadline);
    return -::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
  }
  int wait_readable(int socket, Time timeout) noexcept override {
    pollfd watched{socket, POLLIN, 0};
    const timespec most = sys::to_timespec(timeout);
    return result_of(::ppoll(&watched, 1, &most, nullptr));
  }
  Time monotonic() noexcept override { return sys::read_clock(CLOCK_MONOTONIC); }
  Time realtime() noexcept override { return sys::read_clock(CLOCK_REALTIME); }
};

}  // namespace

Kernel& system_kernel() noexcept {
  static SystemKernel kernel;
  return kernel;
}

}  // namespace can
