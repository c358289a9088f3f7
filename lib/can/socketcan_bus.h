#pragma once

#include <cstdint>
#include <vector>

#include "can/bus.h"
#include "can/echo_guard.h"
#include "can/frame_clock.h"
#include "can/frame_filter.h"
#include "can/kernel.h"
#include "can/link_board.h"
#include "can/link_kernel.h"
#include "can/receive_batch.h"

namespace can {

/// How a SocketCAN bus is built.
struct SocketcanSettings {
  std::vector<FrameFilter> filters;  ///< what is received, at most 512; own frames need one as well
  bool wake_on_frame = false;        ///< `wait_until` comes back for each frame, for more system calls
  Time interval{0};                  ///< after which the echo of a frame is missed, see EchoGuard; 0: never
};

/// A CAN network interface of the kernel as a bus. The bus's clock is CLOCK_MONOTONIC.
///
/// The interface may be missing, go and come back at any time: a `LinkWatch` on another thread tells through
/// the board, `status` takes it up, and `send` says `interface_down` meanwhile.
///
/// System calls of the realtime thread: `wait_until` sleeps once, or not at all when the deadline has passed;
/// `receive` asks the kernel at most once after each `wait_until`, for up to `ReceiveBatch::kFrames` frames;
/// `send` is one call, and none while nothing can be sent or frames are held back. `status` makes none, but
/// for two when the interface has come back, and one when a controller that nobody acknowledges is to be
/// reset. With `wake_on_frame`, and in `wait_for_frame`, each frame can cost one sleep and one look more.
///
/// A frame's time is that of its end: when the driver was told that it had been sent or received, by the
/// controller's clock, the kernel's, or at worst that of the look. Error frames are counted and not handed
/// out; so are frames of other sizes.
class SocketcanBus final : public Bus {
 public:
  /// Opens the socket; both references must outlive the bus. Throws std::system_error when the kernel has no
  /// SocketCAN or refuses an option.
  SocketcanBus(const SocketcanSettings& settings, LinkBoard& board, LinkKernel& links,
               Kernel& kernel = system_kernel());
  ~SocketcanBus() override;
  SocketcanBus(const SocketcanBus&) = delete;
  SocketcanBus& operator=(const SocketcanBus&) = delete;

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
  void set_options();
  int set_filters() noexcept;
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
  std::vector<can_filter> filters_;
  const int socket_;
  FrameClock clock_;
  ReceiveBatch batch_;
  unsigned batch_size_ = 0;
  unsigned batch_next_ = 0;
  bool looked_ = false;      ///< since the last sleep
  std::uint32_t bound_ = 0;  ///< index of the interface the socket is bound to
  std::uint32_t drops_seen_ = 0;
  std::uint32_t resets_ = 0;  ///< number of the last reset asked for
  bool reset_asked_ = false;  ///< and not answered when last looked at
  bool down_seen_ = false;    ///< since then the socket has told that the interface was down
  Time next_reset_{};         ///< the guard's, after one that failed
  bool was_bus_off_ = false;
  EchoGuard guard_;
  ControllerStatus status_;
  TimestampSource source_ = TimestampSource::thread;
};

}  // namespace can
