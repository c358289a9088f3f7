#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "can/link_facts.h"

namespace can {

/// The system calls with which network interfaces are watched and restarted, so that a test can stand in for
/// the kernel. For one thread of normal priority, but for `interrupt`.
class LinkKernel {
 public:
  virtual ~LinkKernel() = default;

  /// What the kernel knows of interface `name` now, and the adapter behind it; not present when there is none or it does not answer
  /// within a second.
  virtual LinkFacts read(const std::string& name) noexcept = 0;

  /// Waits until something about any interface has changed, `interrupt` was called, or `most` has passed.
  virtual void wait(std::chrono::milliseconds most) noexcept = 0;

  /// Makes the running or next `wait` return. Any thread; one system call.
  virtual void interrupt() noexcept = 0;

  /// Lets a bus-off controller take part in the bus again. 0, or -errno: -EPERM without CAP_NET_ADMIN.
  virtual int restart(std::uint32_t index) noexcept = 0;

  /// Sets the interface up or down. 0, or -errno: -EPERM without CAP_NET_ADMIN.
  virtual int set_up(std::uint32_t index, bool up) noexcept = 0;
};

/// The kernel that runs this program, over NETLINK_ROUTE. Throws std::system_error when it has no netlink or
/// the process no descriptor left.
///
/// libsocketcan is not used: its requests wait for ever when the interface disappears while it asks, which is
/// what an unplugged adapter does, and each value is one request more.
std::unique_ptr<LinkKernel> make_link_kernel();

}  // namespace can
