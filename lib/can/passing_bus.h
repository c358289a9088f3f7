#pragma once

#include "can/bus.h"

namespace can {

/// A bus before another one, to which it passes everything on; what derives from it changes or watches some
/// of that. `wait_for_frame` goes through `wait_until`. Realtime safe, as far as the bus behind it is.
class PassingBus : public Bus {
 public:
  Time now() noexcept override { return behind_.now(); }
  Wake wait_until(Time deadline) noexcept override { return behind_.wait_until(deadline); }
  bool receive(ReceivedFrame& out) noexcept override { return behind_.receive(out); }
  SendResult send(const Frame& frame) noexcept override { return behind_.send(frame); }
  ControllerStatus status() noexcept override { return behind_.status(); }
  ResetResult reset() noexcept override { return behind_.reset(); }
  ResetResult reset_result() noexcept override { return behind_.reset_result(); }
  TimestampSource timestamp_source() noexcept override { return behind_.timestamp_source(); }

 protected:
  /// `behind` must outlive the bus.
  explicit PassingBus(Bus& behind) noexcept : behind_(behind) {}

  Bus& behind_;
};

}  // namespace can
