#include "can/raw_socket.h"

#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "can/socketcan/kernel_frame.h"
#include "system/clock.h"

namespace can {
namespace {

// The kernel stamps frames with CLOCK_REALTIME; only the age of a stamp can be moved to another clock.
Time monotonic(const timespec& stamp) noexcept {
  const Time at = sys::from_timespec(stamp);
  const Time age = sys::read_clock(CLOCK_REALTIME) - at;
  const Time now = sys::read_clock(CLOCK_MONOTONIC);
  // After a step of the wall clock the stamp says nothing.
  return age < Time{0} || age > std::chrono::seconds(10) ? now : now - age;
}

template <class Value>
bool set_option(int descriptor, int level, int option, const Value& value) noexcept {
  return ::setsockopt(descriptor, level, option, &value, sizeof value) == 0;
}

ifreq request_of(const std::string& interface) noexcept {
  ifreq request{};
  std::copy_n(interface.begin(), std::min<std::size_t>(interface.size(), IFNAMSIZ - 1), request.ifr_name);
  return request;
}

}  // namespace

SocketResult RawSocket::failure(int error) noexcept {
  error_ = error;
  switch (error) {
    case EAGAIN:
    case EINTR:
      return SocketResult::nothing;
    case ENOBUFS:
      return SocketResult::queue_full;
    case ENETDOWN:
      return SocketResult::interface_down;
    case ENODEV:
    case ENXIO:
      return SocketResult::interface_gone;
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
      return SocketResult::no_can;
    default:
      return SocketResult::failed;
  }
}

SocketResult RawSocket::open(const std::string& interface) noexcept {
  close();
  dropped_ = 0;
  socket_.reset(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!is_open()) return failure(errno);
  const auto give_up = [this](int error) {
    close();
    return failure(error);
  };
  ifreq request = request_of(interface);
  if (::ioctl(descriptor(), SIOCGIFINDEX, &request) != 0) return give_up(errno);
  const int on = 1;
  const can_err_mask_t every_error = CAN_ERR_MASK;
  if (!set_option(descriptor(), SOL_CAN_RAW, CAN_RAW_ERR_FILTER, every_error) ||
      !set_option(descriptor(), SOL_SOCKET, SO_TIMESTAMPNS, on) ||
      !set_option(descriptor(), SOL_SOCKET, SO_RXQ_OVFL, on)) {
    return give_up(errno);
  }
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): how addresses are passed to the kernel
  if (::bind(descriptor(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return give_up(errno);
  index_ = request.ifr_ifindex;
  return SocketResult::done;
}

void RawSocket::adopt(int descriptor) noexcept {
  close();
  dropped_ = 0;
  socket_.reset(descriptor);
}

void RawSocket::close() noexcept {
  socket_.reset();
  index_ = 0;
}

SocketResult RawSocket::receive(ReceivedFrame& out) noexcept {
  can_frame frame{};
  iovec part{&frame, sizeof frame};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t))];
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t size = ::recvmsg(descriptor(), &message, 0);
  if (size < 0) return failure(errno);
  if (size != static_cast<ssize_t>(CAN_MTU)) return SocketResult::nothing;
  out.frame = from_kernel(frame);
  out.own = (message.msg_flags & MSG_CONFIRM) != 0;
  out.end = sys::read_clock(CLOCK_MONOTONIC);
  for (cmsghdr* part_of = CMSG_FIRSTHDR(&message); part_of != nullptr;
       part_of = CMSG_NXTHDR(&message, part_of)) {
    if (part_of->cmsg_level != SOL_SOCKET) continue;
    if (part_of->cmsg_type == SCM_TIMESTAMPNS) {
      timespec stamp{};
      std::memcpy(&stamp, CMSG_DATA(part_of), sizeof stamp);
      out.end = monotonic(stamp);
    } else if (part_of->cmsg_type == SO_RXQ_OVFL) {
      std::uint32_t dropped = 0;
      std::memcpy(&dropped, CMSG_DATA(part_of), sizeof dropped);
      // The kernel's counter has 32 bits.
      dropped_ += dropped - static_cast<std::uint32_t>(dropped_);
    }
  }
  return SocketResult::done;
}

SocketResult RawSocket::send(const Frame& frame) noexcept {
  const can_frame out = to_kernel(frame);
  if (::write(descriptor(), &out, sizeof out) == static_cast<ssize_t>(sizeof out)) return SocketResult::done;
  const SocketResult result = failure(errno);
  return result == SocketResult::nothing ? SocketResult::queue_full : result;
}

SocketResult RawSocket::link() noexcept {
  if (!is_open()) return SocketResult::interface_gone;
  if (index_ == 0) return SocketResult::done;
  // By the index: another interface of the same name is not the one this socket is bound to.
  ifreq request{};
  request.ifr_ifindex = index_;
  if (::ioctl(descriptor(), SIOCGIFNAME, &request) != 0) return failure(errno);
  if (::ioctl(descriptor(), SIOCGIFFLAGS, &request) != 0) return failure(errno);
  return (request.ifr_flags & IFF_UP) != 0 ? SocketResult::done : SocketResult::interface_down;
}

}  // namespace can
