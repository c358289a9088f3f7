#pragma once

#include <linux/can.h>

#include <cstdint>
#include <vector>

#include "can/frame_filter.h"
#include "can/socketcan/kernel.h"

namespace can {

/// The raw sockets of a bus, made and closed on a thread of normal priority: filters, binding and closing take the
/// kernel's lock of the network configuration, which somebody who sets up any interface may hold for a second. The
/// realtime thread gets a descriptor that is ready, over the LinkBoard.
class BusSockets {
 public:
  /// Highest descriptor of a socket: what the LinkBoard has room for, above what the kernel allows a process.
  static constexpr int kMost = 0xFFFFFE;

  /// `filters`: what is received, at most 512; own frames need one as well. Opens the first socket. Throws
  /// std::system_error when the kernel has no SocketCAN or refuses an option.
  explicit BusSockets(const std::vector<FrameFilter>& filters, Kernel& kernel = system_kernel());
  /// Closes all; no other thread uses one any more.
  ~BusSockets();
  BusSockets(const BusSockets&) = delete;
  BusSockets& operator=(const BusSockets&) = delete;

  /// The socket that is bound to the interface with this index, 0: to none. -1: there is none, or the interface has
  /// gone again.
  int bound_to(std::uint32_t index) noexcept;

  /// Closes the sockets before the one of `bound_to`, but for the one that is still `in_use`.
  void close_others(int in_use) noexcept;

 private:
  /// Descriptor of a socket that is bound to nothing, or -errno; `what` then says what was refused.
  int make(const char*& what) noexcept;
  int set_options(int socket, const char*& what) noexcept;

  Kernel& kernel_;
  const std::vector<can_filter> filters_;
  int spare_ = -1;  ///< bound to nothing
  int bound_ = -1;
  std::uint32_t index_ = 0;   ///< of the interface that `bound_` is bound to
  std::vector<int> retired_;  ///< to be closed
};

}  // namespace can
