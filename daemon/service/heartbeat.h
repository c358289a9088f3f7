#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace cansyncd {

/// Decides when the service manager's watchdog is fed: only when both the realtime thread and the gateway
/// thread have come further since it was fed last. Pure: no clock, no thread.
class Heartbeat {
 public:
  /// How far the two threads have come: any number that rises with each pass.
  struct Progress {
    std::uint64_t realtime = 0;  ///< wake-ups for a SYNC edge
    std::uint64_t gateway = 0;   ///< passes
  };

  /// `timeout`: the watchdog's; nothing: there is none.
  explicit Heartbeat(std::optional<std::chrono::microseconds> timeout) : timeout_(timeout) {}

  /// How often to look: four times in the timeout, so that one look may come late; nothing: never.
  std::optional<std::chrono::microseconds> period() const {
    if (!timeout_) return std::nullopt;
    return *timeout_ / 4;
  }

  /// True when the watchdog is to be fed now.
  bool look(const Progress& now) {
    if (now.realtime == fed_.realtime || now.gateway == fed_.gateway) return false;
    fed_ = now;
    return true;
  }

 private:
  std::optional<std::chrono::microseconds> timeout_;
  Progress fed_;
};

}  // namespace cansyncd
