#pragma once

#include <chrono>
#include <optional>

#include "can/bus.h"
#include "sim/node.h"

namespace sim {

/// What an interval of fault scripts lasts on a bus without SYNC.
inline constexpr can::Time kFaultInterval = std::chrono::milliseconds(1);

/// Makes edges at a fixed interval and sends nothing: on a line whose protocol has no SYNC the intervals of
/// fault scripts are counted by it.
class Metronome final : public Node {
 public:
  /// `interval` is over 0.
  explicit Metronome(can::Time interval) : interval_(interval) {}

  NodeNumber node_number() const noexcept override { return 0; }
  bool accepts(const can::Frame&) const noexcept override { return false; }
  void on_sync(can::Time) noexcept override {}
  std::optional<Transmission> on_frame(const can::Frame&, can::Time) noexcept override {
    return std::nullopt;
  }
  std::optional<Transmission> on_join(can::Time now) noexcept override {
    next_ = now;
    return std::nullopt;
  }
  std::optional<can::Time> next_time() const noexcept override { return next_; }
  Deed on_time(can::Time) noexcept override {
    next_ += interval_;
    return {.sync_edge = true, .transmission = std::nullopt};
  }

 private:
  can::Time interval_;
  can::Time next_{};
};

}  // namespace sim
