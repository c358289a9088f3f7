#pragma once

#include <cstdint>

#include "can/bus.h"
#include "can/link_board.h"
#include "can/link_kernel.h"
#include "can/socketcan/echo_guard.h"
#include "can/socketcan/frame_clock.h"
#include "can/socketcan/kernel.h"
#include "can/socketcan/receive_batch.h"

namespace can {

/// How a SocketCAN bus is built.
struct SocketcanSettings {
  bool wake_on_frame = false;  ///< `wait_until` comes back for each frame, for more system calls
  Time interval{0};            ///< after which the echo of a frame is missed, see EchoGuard; 0: never
};

/// A CAN network interface of the kernel as a bus. The bus's clock is CLOCK_MONOTONIC.
///
/// The interface may be missing, go and come back at any time: a `LinkWatch` on another thread tells through
/// the board, `status` takes it up, and `send` says `interface_down` meanwhile.
///
/// System calls of the realtime thread: `wait_until` sleeps once, or not at all when the deadline has passed;
/// `receive` asks the kernel at most once after each `wait_until`, for up to `ReceiveBatch::kFrames` frames;
/// `send` is one call, and none while nothing can be sent or frames are held back. `status` makes none, but
/// for one when a controller that nobody acknowledges is to be reset. With `wake_on_frame`, and in `wait_for_frame`, each frame can cost one sleep and one look more.
///
/// A frame's time is that of its end: when the driver was told that it had been sent or received, by the
/// controller's clock, the kernel's, or at worst that of the look. Error frames are counted and not handed
/// out; so are frames of other sizes.
class SocketcanBus final : public Bus {
 public:
  /// The three must outlive the bus. Its sockets come over the board.
  SocketcanBus(const SocketcanSettings& settings, LinkBoard& board, LinkKernel& links,
               Kernel& kernel = system_kernel()) noexcept;

  Time now() noexcept override { return kernel_.monotonic(); }
  Wake wait_until(Time deadline) noexcept override { return sleep(deadline, wake_on_frame_); }
  Wake wait_for_frame(Time deadline) noexcept override { return sleep(deadline, true); }
  bool receive(ReceivedFrame& out) noexcept override;
  SendResult send(const Frame& frame) noexcept override;
  ControllerStatus status() noexcept override;
  /// Asks the link watch; one system call, which wakes it.
  ResetResult reset() noexcept override;
  ResetResult reset_result() noexcept override;
  /// `thread` until the first frame has come.
  TimestampSource timestamp_source() noexcept override { return source_; }

 private:
  Wake sleep(Time deadline, bool wake_on_frame) noexcept;
  void take_up_link() noexcept;
  void look() noexcept;
  void guard_controller() noexcept;
  void went_down(Time now) noexcept;
  bool take(const RawMessage& message, ReceivedFrame& out) noexcept;
  void account(const can_frame& error) noexcept;
  void count_drops(std::uint32_t total) noexcept;

  Kernel& kernel_;
  LinkBoard& board_;
  LinkKernel& links_;
  const bool wake_on_frame_;
  int socket_ = -1;  ///< of the board, bound to the interface; -1: none
  FrameClock clock_;
  ReceiveBatch batch_;
  unsigned batch_size_ = 0;
  unsigned batch_next_ = 0;
  bool looked_ = false;           ///< since the last sleep
  std::uint32_t drops_seen_ = 0;  ///< of this socket
  std::uint32_t resets_ = 0;      ///< number of the last reset asked for
  bool reset_asked_ = false;      ///< and not answered when last looked at
  bool down_seen_ = false;        ///< since then the socket has told that the interface was down
  Time next_reset_{};             ///< the guard's, after one that failed
  bool was_bus_off_ = false;
  EchoGuard guard_;
  ControllerStatus status_;
  TimestampSource source_ = TimestampSource::thread;
};

}  // namespace can
