#pragma once

#include "can/bus.h"

namespace cansyncd::test {

/// A bus on which nothing happens, to derive from: time passes with sleeping alone, and every frame is taken.
class SilentBus : public can::Bus {
 public:
  can::Time now() noexcept override { return now_; }
  can::Wake wait_until(can::Time deadline) noexcept override {
    if (deadline > now_) now_ = deadline;
    return can::Wake::deadline;
  }
  bool receive(can::ReceivedFrame&) noexcept override { return false; }
  can::SendResult send(const can::Frame&) noexcept override { return can::SendResult::queued; }
  can::ControllerStatus status() noexcept override { return {}; }
  can::ResetResult reset() noexcept override { return can::ResetResult::done; }
  can::ResetResult reset_result() noexcept override { return can::ResetResult::done; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::simulation; }

 protected:
  can::Time now_{};
};

}  // namespace cansyncd::test
