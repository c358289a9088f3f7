#pragma once

#include <string>

#include "can/raw_socket.h"
#include "simulator/port.h"

namespace cansync_sim {

/// A CAN interface of the kernel. Ends its waits for SIGTERM and SIGINT, which it blocks outside of them for
/// the calling thread. Looks for a lost interface ten times a second.
class SocketPort final : public Port {
 public:
  explicit SocketPort(std::string interface);

  can::Time now() noexcept override;
  bool wait(can::Time deadline) noexcept override;
  bool receive(can::ReceivedFrame& out) noexcept override;
  can::SendResult send(const can::Frame& frame) noexcept override;
  Link link() noexcept override { return link_; }
  std::uint64_t dropped() noexcept override { return dropped_ + socket_.dropped(); }

  /// Empty, or why CAN sockets cannot be had at all on this machine, and the remedy.
  std::string obstacle() const;

 private:
  void look() noexcept;
  void take(can::SocketResult result) noexcept;

  std::string interface_;
  can::RawSocket socket_;
  Link link_ = Link::missing;
  can::SocketResult opened_ = can::SocketResult::interface_gone;
  can::Time looked_at_{};
  std::uint64_t dropped_ = 0;  // of sockets closed before
};

}  // namespace cansync_sim
