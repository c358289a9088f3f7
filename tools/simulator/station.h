#pragma once

#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "can/frame.h"

namespace cansync_sim {

/// What the program puts on a bus that is not simulated, sans-IO: it is given the frames that were received
/// and asked which frame is to be sent next. One thread; nothing allocates or throws after construction.
class Station {
 public:
  virtual ~Station() = default;

  /// A frame was received; `now` is the present in the clock of `frame.end`.
  virtual void receive(const can::ReceivedFrame& frame, can::Time now) noexcept = 0;

  /// When the next frame is to be sent; `can::Time::max()` when none waits.
  virtual can::Time next_due() const noexcept = 0;

  /// Takes the next frame to be sent at `now`; nothing when none is due.
  virtual std::optional<can::Frame> next(can::Time now) noexcept = 0;

  /// Tells what became of the frame that `next` gave last.
  virtual void sent(can::SendResult result) noexcept = 0;

  /// The interface is lost: what waits is not sent any more.
  virtual void link_lost() noexcept = 0;
};

}  // namespace cansync_sim
