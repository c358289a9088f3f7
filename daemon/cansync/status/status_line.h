#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "cansync/config/config.h"
#include "daemon/cansync/exchange.h"

namespace cansyncd {

/// The line in one sentence, for `systemctl status`: what keeps it from running first, else operating state,
/// how many of the configured slaves respond, who does not, bus and bit rate. Pure; allocates.
std::string status_text(const MasterSnapshot& master, const Config& config);

/// Tells the service manager the state of the line, on the edge and not more often than once a second.
/// Gateway thread only.
class StatusLine {
 public:
  using Tell = std::function<void(const std::string&)>;
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::seconds kPeriod{1};

  explicit StatusLine(Tell tell) : tell_(std::move(tell)) {}

  /// Tells `master`'s state when it differs from what was told. Returns when to call again when it had to
  /// wait; nothing: no need.
  std::optional<Time> step(const MasterSnapshot& master, const Config& config, Time now);

 private:
  Tell tell_;
  std::string told_;
  std::optional<Time> last_;
};

}  // namespace cansyncd
