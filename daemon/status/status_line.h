#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "can/bus.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// What keeps a bus from sending, in one sentence; empty: nothing. Pure; allocates.
std::string bus_problem(const can::ControllerStatus& controller, const BusConfig& bus);

/// A bus in one sentence: what keeps it from sending, else `state` with the name and the bit rate of the bus. Pure;
/// allocates.
std::string bus_sentence(const std::string& state, const can::ControllerStatus& controller,
                         const BusConfig& bus);

/// Tells the service manager how a bus is, on the edge and not more often than once a second: for `systemctl status`.
/// Gateway thread only.
class StatusLine {
 public:
  using Tell = std::function<void(const std::string&)>;
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kPeriod{1};

  explicit StatusLine(Tell tell) : tell_(std::move(tell)) {}

  /// Tells what `text()` says when that differs from what was told. Returns when to call again when it had to wait;
  /// nothing: no need.
  template <class Text>
  std::optional<Time> step(Text&& text, Time now) {
    if (last_ && now - *last_ < kPeriod) return *last_ + kPeriod;
    std::string newest = text();
    if (newest == told_) return std::nullopt;
    told_ = std::move(newest);
    last_ = now;
    tell_(told_);
    return std::nullopt;
  }

 private:
  Tell tell_;
  std::string told_;
  std::optional<Time> last_;
};

}  // namespace cansyncd
