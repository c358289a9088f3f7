#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "daemon/desk/gateway_events.h"

namespace cansyncd {

/// Tells when received frames are lost on their way to the clients: the first of a row, and how many they
/// were once none was for `kQuiet`. Gateway thread only.
class DroppedFrames {
 public:
  static constexpr std::chrono::seconds kQuiet{3};

  /// `what`: the plural of what is received; a literal.
  explicit DroppedFrames(std::string_view what) noexcept : what_(what) {}

  /// `lost`: all so far.
  void tell(std::uint64_t lost, EventPublisher& events, SteadyTime now) {
    if (row_.add(lost - std::exchange(told_, lost), now)) {
      events.publish(
          {gateway_SEVERITY_WARNING, "frames_dropped", -1,
           fmt::format("received {} are not published, because they come faster than they can be; take "
                       "fewer by ranges, or give realtime.report_queue more room",
                       what_),
           std::nullopt},
          now);
    }
    if (const std::uint64_t row = row_.take_over(now); row != 0) {
      events.publish(
          {gateway_SEVERITY_INFO, "frames_dropped_over", -1,
           fmt::format("received {} are all published again; {} were not", what_, row), std::nullopt},
          now);
    }
  }

  /// When to call `tell` again at the latest; nothing: no need.
  std::optional<SteadyTime> next() const { return row_.next(); }

 private:
  const std::string_view what_;
  FaultRow row_{kQuiet};
  std::uint64_t told_ = 0;
};

}  // namespace cansyncd
