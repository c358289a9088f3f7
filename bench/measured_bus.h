#pragma once

#include "bench/timing_histogram.h"
#include "can/bus.h"
#include "sync/sync_wire.h"

namespace bench {

/// A bus with its SYNC wire that notes how punctual the realtime loop is; all else is passed on to the bus
/// behind it.
///
/// Lateness is from the instant the SYNC edge was due to the call that makes it. Handing over is the time
/// from waking up to the end of `send`, summed over the telegrams of an interval.
class MeasuredBus final : public can::Bus, public sync_line::SyncWire {
 public:
  /// `wire`: null when the bus has none. Both must outlive this bus.
  MeasuredBus(can::Bus& bus, sync_line::SyncWire* wire) : bus_(bus), wire_(wire) {}

  can::Time now() noexcept override { return bus_.now(); }
  can::Wake wait_until(can::Time deadline) noexcept override {
    const can::Wake wake = bus_.wait_until(deadline);
    woke_ = bus_.now();
    return wake;
  }
  bool receive(can::ReceivedFrame& out) noexcept override { return bus_.receive(out); }
  can::SendResult send(const can::Frame& frame) noexcept override {
    const can::SendResult result = bus_.send(frame);
    const can::Time done = bus_.now();
    handing_over_ += done - woke_;
    woke_ = done;
    ++telegrams_;
    return result;
  }
  void sync_edge(can::Time due) noexcept override {
    lateness_.add(bus_.now() - due);
    if (telegrams_ >= 3) to_handed_over_.add(handing_over_);
    handing_over_ = {};
    telegrams_ = 0;
    if (wire_ != nullptr) wire_->sync_edge(due);
  }
  can::ControllerStatus status() noexcept override { return bus_.status(); }
  can::ResetResult reset() noexcept override { return bus_.reset(); }
  can::ResetResult reset_result() noexcept override { return bus_.reset_result(); }
  can::TimestampSource timestamp_source() noexcept override { return bus_.timestamp_source(); }

  const TimingHistogram& lateness() const noexcept { return lateness_; }
  const TimingHistogram& handed_over() const noexcept { return to_handed_over_; }

 private:
  can::Bus& bus_;
  sync_line::SyncWire* wire_;
  can::Time woke_{};
  can::Time handing_over_{};
  unsigned telegrams_ = 0;
  TimingHistogram lateness_;
  TimingHistogram to_handed_over_;
};

}  // namespace bench
