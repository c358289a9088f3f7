#pragma once

#include <cstdint>

#include "daemon/cansync_slave/exchange.h"

namespace cansyncd {

/// The actions that the realtime thread tells, each once and in their order, and among them the newest control
/// word for which there was no room. Gateway thread only.
class ActionReports {
 public:
  /// `exchange` must outlive this object.
  explicit ActionReports(SlaveExchange& exchange) noexcept : exchange_(exchange) {}

  /// Calls `tell` with what has come. A number that rises by more than one says that some are lost.
  template <class Tell>
  void take(Tell&& tell) {
    (void)exchange_.lost_control_word.read(lost_);
    ActionReport report;
    while (exchange_.actions.try_pop(report)) {
      // What is missing before it was written before it.
      if (report.number != told_ + 1) (void)exchange_.lost_control_word.read(lost_);
      if (lost_.number < report.number) give(lost_, tell);
      give(report, tell);
    }
    give(lost_, tell);
  }

 private:
  template <class Tell>
  void give(const ActionReport& report, Tell&& tell) {
    if (report.number <= told_) return;
    told_ = report.number;
    tell(report);
  }

  SlaveExchange& exchange_;
  ActionReport lost_;
  std::uint64_t told_ = 0;  ///< number of the newest
};

}  // namespace cansyncd
