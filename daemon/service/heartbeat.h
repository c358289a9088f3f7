#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cansyncd {

/// Decides when the service manager's watchdog is fed: only when the realtime thread and the gateway thread
/// of every bus have come further since it was fed last. No clock, no thread of its own.
class Heartbeat {
 public:
  /// How far the two threads have come: any number that rises with each pass.
  struct Progress {
    std::uint64_t realtime = 0;  ///< wake-ups for a SYNC edge
    std::uint64_t gateway = 0;   ///< passes
    bool further_than(const Progress& before) const {
      return realtime != before.realtime && gateway != before.gateway;
    }
  };

  /// `timeout`: the watchdog's; nothing: there is none.
  explicit Heartbeat(std::optional<std::chrono::microseconds> timeout) : timeout_(timeout) {}

  /// How often to look: four times in the timeout, so that one look may come late; nothing: never.
  std::optional<std::chrono::microseconds> period() const {
    if (!timeout_) return std::nullopt;
    return *timeout_ / 4;
  }

  /// True when the watchdog is to be fed now. `now`: of every bus, always in the same order.
  bool look(std::span<const Progress> now) {
    fed_.resize(now.size());
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (!now[i].further_than(fed_[i])) return false;
    }
    fed_.assign(now.begin(), now.end());
    return true;
  }

 private:
  std::optional<std::chrono::microseconds> timeout_;
  std::vector<Progress> fed_;
};

}  // namespace cansyncd
