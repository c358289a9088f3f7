#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "can/passing_bus.h"

namespace given {

/// The simulated bus, with what can happen to a controller: frames stay in it, it takes none, it is off the bus, or
/// its interface only listens. Keeps what of the daemon stood on the bus.
class DisturbedBus : public can::PassingBus {
 public:
  explicit DisturbedBus(can::Bus& line) : PassingBus(line) {}

  bool full = false;                                ///< the controller has no room
  bool keeps = false;                               ///< frames stay in the controller: others have the bus
  bool listens_only = false;                        ///< set so, the interface sends nothing
  std::vector<can::Frame> own;                      ///< stood on the bus
  std::function<bool(const can::Frame&)> concerns;  ///< frames that `full` and `keeps` are for; empty: all

  /// What stayed in the controller goes on the bus.
  void let_go() {
    keeps = false;
    for (const can::Frame& frame : kept_) (void)behind_.send(frame);
    kept_.clear();
  }
  /// Off the bus, and what was in the controller is lost.
  void take_off() {
    off_ = true;
    kept_.clear();
  }
  void bring_back() {
    off_ = false;
    ++restarts_;
  }
  /// A frame of another node comes now.
  void bring(const can::Frame& frame) { brought_.push_back(frame); }

  bool receive(can::ReceivedFrame& out) noexcept override {
    if (!brought_.empty()) {
      out = {brought_.front(), behind_.now(), false};
      brought_.erase(brought_.begin());
      return true;
    }
    if (!behind_.receive(out)) return false;
    if (out.own) own.push_back(out.frame);
    return true;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    if (listens_only) return can::SendResult::interface_down;
    if (off_) return can::SendResult::bus_off;
    const bool concerned = !concerns || concerns(frame);
    if (full && concerned) return can::SendResult::queue_full;
    if (!keeps || !concerned) return behind_.send(frame);
    kept_.push_back(frame);
    return can::SendResult::queued;
  }
  can::ControllerStatus status() noexcept override {
    can::ControllerStatus status = behind_.status();
    if (off_) status.state = can::ControllerState::bus_off;
    if (listens_only) status.link = can::LinkState::listen_only;
    status.restarts += restarts_;
    return status;
  }

 private:
  bool off_ = false;
  std::uint64_t restarts_ = 0;
  std::vector<can::Frame> kept_;
  std::vector<can::Frame> brought_;
};

}  // namespace given
