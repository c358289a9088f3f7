#pragma once

#include <cstdint>

#include "can/bus.h"
#include "can/frame.h"

namespace cansync_sim {

/// State of the interface behind a port.
enum class Link : std::uint8_t { up, down, missing };

/// What the simulator program needs of the world: a clock, an interface, and to be told when to stop. A test
/// stands in for it. One thread; nothing throws.
class Port {
 public:
  virtual ~Port() = default;

  /// The clock of `can::ReceivedFrame::end`.
  virtual can::Time now() noexcept = 0;

  /// Sleeps until `deadline` (`can::Time::max()`: without end), a frame, a change of the link that must be
  /// looked at, or the wish to stop. False: stop.
  virtual bool wait(can::Time deadline) noexcept = 0;

  /// Takes the oldest received frame; false when there is none.
  virtual bool receive(can::ReceivedFrame& out) noexcept = 0;

  /// Sends a frame at once, or not at all.
  virtual can::SendResult send(const can::Frame& frame) noexcept = 0;

  /// State of the interface, as of the last operation.
  virtual Link link() noexcept = 0;

  /// Frames lost because they were not taken in time.
  virtual std::uint64_t dropped() noexcept = 0;
};

}  // namespace cansync_sim
