#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <cstddef>

#include "can/bus.h"

namespace can {

/// Every system call of the SocketCAN bus, so that a test can stand in for the kernel.
///
/// Functions that return `int` return 0 or more when they succeed and `-errno` when not. None throws or
/// allocates. What the realtime thread calls is realtime safe as far as the kernel's call is; the two clocks
/// are read without a system call where the kernel offers that (vDSO).
class Kernel {
 public:
  virtual ~Kernel() = default;

  /// A raw CAN socket, non-blocking and closed on exec; returns its descriptor. -EAFNOSUPPORT: the kernel has
  /// no SocketCAN.
  virtual int open_socket() noexcept = 0;
  virtual void close_socket(int socket) noexcept = 0;
  /// setsockopt().
  virtual int set_option(int socket, int level, int name, const void* value, std::size_t size) noexcept = 0;
  /// Binds to the interface with index `interface`, over 0. -ENODEV: there is none.
  virtual int bind_to(int socket, int interface) noexcept = 0;
  /// Hands over one frame. -ENOBUFS, -EAGAIN: no room; -ENETDOWN, -ENODEV, -ENXIO: no interface.
  virtual int send_frame(int socket, const can_frame& frame) noexcept = 0;
  /// recvmmsg() without waiting: the number of messages taken. -EAGAIN: none is there.
  virtual int receive(int socket, mmsghdr* messages, unsigned count) noexcept = 0;
  /// Sleeps until `deadline` of the monotonic clock. -EINTR: a signal came.
  virtual int sleep_until(Time deadline) noexcept = 0;
  /// Sleeps at most `timeout`, or until something can be received: 1 it can, 0 the time is over.
  virtual int wait_readable(int socket, Time timeout) noexcept = 0;
  /// CLOCK_MONOTONIC.
  virtual Time monotonic() noexcept = 0;
  /// CLOCK_REALTIME.
  virtual Time realtime() noexcept = 0;
};

/// The kernel that runs this program. Lives as long as the program.
Kernel& system_kernel() noexcept;

}  // namespace can
