#pragma once

#include <chrono>
#include <csignal>
#include <optional>

namespace cansyncd {

/// The signals the daemon waits for: SIGTERM, SIGINT, SIGHUP, SIGUSR1. Main thread.
class SignalWait {
 public:
  /// Blocks them; every thread started afterwards inherits that.
  SignalWait();

  /// Sleeps until one of them comes, at most `time` (nothing: for ever). Nothing: none came.
  std::optional<int> wait(std::optional<std::chrono::microseconds> time) const;

 private:
  sigset_t set_{};
};

}  // namespace cansyncd
