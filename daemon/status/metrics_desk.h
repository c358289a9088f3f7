#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/desk/gateway_events.h"
#include "daemon/status/metrics_file.h"
#include "daemon_config/daemon_config.h"

namespace cansyncd {

/// Has the metrics file written in time. Gateway thread only, apart from making and ending it.
class MetricsDesk {
 public:
  /// Makes the file's text; gets how often it could not be written.
  using Render = std::function<std::string(std::uint64_t write_failures)>;

  /// Its end removes the file. Does nothing when no file is configured. `tell` is called on the writing
  /// thread. Throws std::system_error when there is no thread to be had.
  MetricsDesk(const MetricsConfig& config, MetricsFile::Tell tell, Render render);

  /// Has `render` make the text when it is time. Returns when to call again; nothing: no need.
  std::optional<SteadyTime> step(SteadyTime now);

 private:
  const std::chrono::seconds period_;
  const Render render_;
  std::unique_ptr<MetricsFile> file_;  ///< null: none configured
  std::optional<SteadyTime> written_;
};

}  // namespace cansyncd
