#pragma once

#include <vector>

#include "can/bus.h"
#include "daemon/cansync/exchange.h"

namespace cansyncd::campaign {

/// Stands between the loop and everything it touches, and changes nothing: what breaks a variant of the
/// product on purpose derives from it.
class Tamper : public can::Bus {
 public:
  /// The bus below; must outlive the object. `end` is the interval after which no fault is provoked.
  void attach(can::Bus& below) noexcept { below_ = &below; }

  can::Time now() noexcept override { return below_->now(); }
  can::Wake wait_until(can::Time deadline) noexcept override { return below_->wait_until(deadline); }
  bool receive(can::ReceivedFrame& out) noexcept override { return below_->receive(out); }
  can::SendResult send(const can::Frame& frame) noexcept override { return below_->send(frame); }
  void sync_edge(can::Time due) noexcept override { below_->sync_edge(due); }
  can::ControllerStatus status() noexcept override { return below_->status(); }
  can::ResetResult reset() noexcept override { return below_->reset(); }
  can::ResetResult reset_result() noexcept override { return below_->reset_result(); }
  can::TimestampSource timestamp_source() noexcept override { return below_->timestamp_source(); }

  /// What the gateway is about to read; may be changed.
  virtual void terminals(std::vector<Terminal>& /*popped*/) {}
  virtual void snapshot(MasterSnapshot& /*snapshot*/) {}
  /// `fresh`: the master has written the report in this interval. Returns whether the gateway sees it.
  virtual bool actual(ActualReport& /*report*/, bool fresh) { return fresh; }

 protected:
  can::Bus& below() noexcept { return *below_; }

 private:
  can::Bus* below_ = nullptr;
};

}  // namespace cansyncd::campaign
