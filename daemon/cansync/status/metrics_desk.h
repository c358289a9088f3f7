#pragma once

#include <memory>
#include <optional>

#include "daemon/cansync/config/config.h"
#include "daemon/cansync/status/gateway_state.h"
#include "daemon/desk/gateway_events.h"
#include "daemon/desk/metrics_file.h"
#include "daemon/status/common_status.h"

namespace cansyncd {

/// Has the metrics file written in time. Gateway thread only, apart from making and ending it.
class MetricsDesk {
 public:
  /// Its end removes the file. Does nothing when no file is configured. `tell` is called on the writing
  /// thread. Throws std::system_error when there is no thread to be had.
  MetricsDesk(const MetricsConfig& config, MetricsFile::Tell tell);

  /// Renders what `state` and `common` have told last when it is time. Returns when to call again; nothing:
  /// no need.
  std::optional<SteadyTime> step(const StatePublisher& state, const CommonStatus& common, SteadyTime now);

 private:
  std::chrono::seconds period_;
  std::unique_ptr<MetricsFile> file_;  ///< null: none configured
  std::optional<SteadyTime> written_;
};

}  // namespace cansyncd
