#pragma once

#include "bench/timing_histogram.h"
#include "can/passing_bus.h"
#include "sync/sync_wire.h"

namespace bench {

/// A bus with its SYNC wire that notes how punctual the realtime loop is; all else is passed on to the bus
/// behind it.
///
/// Lateness is from the instant the SYNC edge was due to the call that makes it. Handing over is the time
/// from waking up to the end of `send`, summed over the telegrams of an interval.
class MeasuredBus final : public can::PassingBus, public sync_line::SyncWire {
 public:
  /// `wire`: null when the bus has none. Both must outlive this bus.
  MeasuredBus(can::Bus& bus, sync_line::SyncWire* wire) : PassingBus(bus), wire_(wire) {}

  can::Wake wait_until(can::Time deadline) noexcept override {
    const can::Wake wake = behind_.wait_until(deadline);
    woke_ = now();
    return wake;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    const can::SendResult result = behind_.send(frame);
    const can::Time done = behind_.now();
    handing_over_ += done - woke_;
    woke_ = done;
    ++telegrams_;
    return result;
  }
  void sync_edge(can::Time due) noexcept override {
    lateness_.add(behind_.now() - due);
    if (telegrams_ >= 3) to_handed_over_.add(handing_over_);
    handing_over_ = {};
    telegrams_ = 0;
    if (wire_ != nullptr) wire_->sync_edge(due);
  }

  const TimingHistogram& lateness() const noexcept { return lateness_; }
  const TimingHistogram& handed_over() const noexcept { return to_handed_over_; }

 private:
  sync_line::SyncWire* wire_;
  can::Time woke_{};
  can::Time handing_over_{};
  unsigned telegrams_ = 0;
  TimingHistogram lateness_;
  TimingHistogram to_handed_over_;
};

}  // namespace bench
