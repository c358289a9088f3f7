#pragma once

#include "can/passing_bus.h"
#include "daemon/loop/deadline_loop.h"

namespace cansyncd {

/// A bus whose owner's thread serves a machine on another bus, too: while the owner sleeps, the machine runs.
/// So one realtime thread drives two buses, and neither loop knows of the other.
///
/// The sleep is that of the other bus, whose frames wake the thread. Frames of this one wake it no more: they
/// are there when it looks, at its own deadlines. What is due on the other bus at a deadline is done before
/// the owner's part. Both buses have the same clock. Realtime thread; nothing allocates, locks or throws.
template <DeadlineMachine Machine>
class BesideBus final : public can::PassingBus {
 public:
  /// Both must outlive the object; `other` is driven by nobody else.
  BesideBus(can::Bus& bus, DeadlineLoop<Machine>& other) noexcept : PassingBus(bus), other_(other) {}

  /// Once, before the owner's loop.
  void begin() noexcept { other_.begin(); }
  /// Once, after the owner's loop.
  void end() noexcept { other_.end(); }

  can::Wake wait_until(can::Time deadline) noexcept override {
    while (other_.served() < deadline) other_.turn(deadline);
    return behind_.wait_until(deadline);  // it has passed: there is nothing to sleep for
  }

 private:
  DeadlineLoop<Machine>& other_;
};

}  // namespace cansyncd
