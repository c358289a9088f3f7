#pragma once

#include <optional>

#include "can/bus.h"
#include "can/socketcan/kernel.h"

namespace can {

/// The times that came with a frame; each in its own clock.
struct FrameStamps {
  std::optional<Time> software;  ///< CLOCK_REALTIME, of the kernel
  std::optional<Time> hardware;  ///< clock of the controller, with any start
};

/// A frame's time in the bus's clock, and where it comes from.
struct StampedTime {
  Time at{};
  TimestampSource source = TimestampSource::thread;
};

/// Translates the stamps of received frames into the monotonic clock. Realtime thread only; no system call.
///
/// Kernel stamps count in CLOCK_REALTIME, which may be set. The offset is measured anew before each batch,
/// and a stamp that lies outside the time in which its batch can have come is tried with the offset before;
/// when both are the same the frame was longer on its way, up to a second.
/// Hardware stamps count in a clock of their own: the least difference to the kernel's stamps of the last
/// two windows of 64 frames is its offset, so that a frame's way through the driver is left out and a clock
/// that runs fast or slow is followed. A stamp that cannot be is not used, but the next worse source.
class FrameClock {
 public:
  explicit FrameClock(Kernel& kernel) noexcept : kernel_(kernel), taken_up_to_(kernel.monotonic()) {}

  /// Before the frames of one look at the kernel are translated. Returns the time of the look.
  Time begin_batch() noexcept;

  /// The time of one frame of the batch, never after the look.
  StampedTime translate(const FrameStamps& stamps) noexcept;

  /// After the batch. `complete`: no frame was left in the kernel.
  void end_batch(bool complete) noexcept;

  /// The interface has changed: its hardware clock begins anew.
  void forget_hardware() noexcept { hardware_ = {}; }

 private:
  struct HardwareOffset {
    std::optional<Time> before;  ///< least of the window that is over
    std::optional<Time> least;   ///< least of the running window
    unsigned frames = 0;
  };

  void measure_offset() noexcept;
  std::optional<Time> from_software(Time stamp) const noexcept;
  std::optional<Time> from_hardware(Time stamp, Time software) noexcept;
  bool plausible(Time at) const noexcept;

  Kernel& kernel_;
  Time look_{};           ///< of the running batch
  Time taken_up_to_{};    ///< look of the last batch that was complete
  Time offset_{};         ///< monotonic - realtime, now
  Time offset_before_{};  ///< likewise, of the batch before
  bool measured_ = false;
  Time least_doubt_{};  ///< of all readings of the offset so far
  HardwareOffset hardware_;
};

}  // namespace can
