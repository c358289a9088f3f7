#pragma once

#include "can/bus.h"
#include "daemon/loop/deadline_loop.h"

namespace cansyncd {

/// A bus whose owner's thread serves a machine on another bus, too: while the owner sleeps, the machine runs.
/// So one realtime thread drives two buses, and neither loop knows of the other.
///
/// The sleep is that of the other bus, whose frames wake the thread. Frames of this one wake it no more: they
/// are there when it looks, at its own deadlines. What is due on the other bus at a deadline is done before
/// the owner's part. Both buses have the same clock. Realtime thread; nothing allocates, locks or throws.
template <DeadlineMachine Machine>
class BesideBus final : public can::Bus {
 public:
  /// Both must outlive the object; `other` is driven by nobody else.
  BesideBus(can::Bus& bus, DeadlineLoop<Machine>& other) noexcept : bus_(bus), other_(other) {}

  /// Once, before the owner's loop.
  void begin() noexcept { other_.begin(); }
  /// Once, after the owner's loop.
  void end() noexcept { other_.end(); }

  can::Time now() noexcept override { return bus_.now(); }
  can::Wake wait_until(can::Time deadline) noexcept override {
    while (other_.served() < deadline) other_.turn(deadline);
    return bus_.wait_until(deadline);  // it has passed: there is nothing to sleep for
  }
  bool receive(can::ReceivedFrame& out) noexcept override { return bus_.receive(out); }
  can::SendResult send(const can::Frame& frame) noexcept override { return bus_.send(frame); }
  can::ControllerStatus status() noexcept override { return bus_.status(); }
  can::ResetResult reset() noexcept override { return bus_.reset(); }
  can::ResetResult reset_result() noexcept override { return bus_.reset_result(); }
  can::TimestampSource timestamp_source() noexcept override { return bus_.timestamp_source(); }

 private:
  can::Bus& bus_;
  DeadlineLoop<Machine>& other_;
};

}  // namespace cansyncd
