#pragma once

#include <linux/can.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "can/socketcan/frame_clock.h"
#include "can/socketcan/kernel.h"

namespace can {

/// A message of the socket, taken apart.
struct RawMessage {
  can_frame frame{};
  bool whole = false;  ///< its size is that of a classic frame
  bool own = false;    ///< sent through this very socket
  FrameStamps stamps;
  std::optional<std::uint32_t>
      drops;  ///< frames the kernel has dropped since the socket was opened, mod 2^32
};

/// Room for the frames of one recvmmsg() call, with all that comes beside them. Takes no memory after its
/// construction; realtime safe. One thread.
class ReceiveBatch {
 public:
  /// Most frames taken with one call.
  static constexpr unsigned kFrames = 64;

  ReceiveBatch() noexcept;
  ReceiveBatch(const ReceiveBatch&) = delete;
  ReceiveBatch& operator=(const ReceiveBatch&) = delete;

  /// One call: the number of messages, or -errno. What the last one brought is gone.
  int receive(Kernel& kernel, int socket) noexcept;

  /// Message `index`, under the number that `receive` returned.
  RawMessage message(unsigned index) const noexcept;

 private:
  /// Three time stamps and a counter, each with its header.
  static constexpr std::size_t kControlSize = 128;
  struct Control {
    alignas(cmsghdr) std::array<std::byte, kControlSize> bytes;
  };

  void prepare(unsigned index) noexcept;

  std::array<can_frame, kFrames> frames_ = {};
  std::array<iovec, kFrames> vectors_ = {};
  std::array<Control, kFrames> controls_ = {};
  std::array<mmsghdr, kFrames> headers_ = {};
  unsigned used_ = 0;  ///< headers that the kernel has written to
};

}  // namespace can
