#pragma once

#include <atomic>
#include <chrono>
#include <span>

#include "daemon/segment/segment.h"
#include "daemon/service/inhibitors.h"
#include "daemon/service/pending_restart.h"

namespace cansyncd {

/// What the daemon has to do with its computer, whatever its buses: what was replaced on disk, and that the
/// computer keeps running while a line does. Main thread.
class HostWatch {
 public:
  static constexpr std::chrono::seconds kPeriod{1};       ///< of `step`
  static constexpr std::chrono::seconds kDiskPeriod{30};  ///< between two looks at the disk

  /// Throws std::system_error without a thread for logind.
  HostWatch();

  /// Looks at the disk when that is due, and takes or gives back the locks of logind.
  void step(std::span<Segment* const> segments);

  /// Looks at the disk now, and shows segments that were made anew what the others know.
  void look_again(std::span<Segment* const> segments);

  /// True when the process is to end because the computer shuts down.
  bool shuts_down() const noexcept { return shuts_down_.load(std::memory_order_relaxed); }

 private:
  ReplacedFiles files_;
  std::chrono::steady_clock::time_point disk_due_;
  std::atomic<bool> shuts_down_{false};
  InhibitorState told_;
  Inhibitors inhibitors_;  ///< last: its thread uses the others
};

}  // namespace cansyncd
