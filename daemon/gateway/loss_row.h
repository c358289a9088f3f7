#pragma once

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "daemon/desk/gateway_events.h"

namespace cansyncd {

/// Tells of what is lost or left out again and again: the first of a row, and how many they were once none was for
/// `kQuiet`. Gateway thread only.
class LossRow {
 public:
  static constexpr std::chrono::seconds kQuiet{3};

  /// What is told.
  struct Texts {
    EventCode begins;       ///< a warning, with `text`
    EventCode over;         ///< an information, with `over_text` and the number
    std::string text;       ///< what happens, why, and the remedy
    std::string over_text;  ///< that it is over; the number follows
  };
  explicit LossRow(Texts texts) : texts_(std::move(texts)) {}

  /// `lost`: all so far.
  void tell(std::uint64_t lost, EventPublisher& events, SteadyTime now) {
    if (row_.add(lost - std::exchange(told_, lost), now))
      events.publish({gateway_SEVERITY_WARNING, texts_.begins, -1, texts_.text, std::nullopt}, now);
    if (const std::uint64_t row = row_.take_over(now); row != 0) {
      events.publish({gateway_SEVERITY_INFO, texts_.over, -1, fmt::format("{}; {}", texts_.over_text, row),
                      std::nullopt},
                     now);
    }
  }

  /// What was lost so far has another reason, which is told elsewhere.
  void pass_over(std::uint64_t lost) noexcept { told_ = lost; }

  /// When to call `tell` again at the latest; nothing: no need.
  std::optional<SteadyTime> next() const { return row_.next(); }

 private:
  Texts texts_;
  FaultRow row_{kQuiet};
  std::uint64_t told_ = 0;
};

/// Of received frames or messages that are not published. `what`: their plural.
inline LossRow::Texts not_published(std::string_view what) {
  return {
      "frames_dropped", "frames_dropped_over",
      fmt::format("received {} are not published, because they come faster than they can be; take fewer by "
                  "ranges, or give realtime.report_queue more room",
                  what),
      fmt::format("received {} are all published again; not published", what)};
}

}  // namespace cansyncd
