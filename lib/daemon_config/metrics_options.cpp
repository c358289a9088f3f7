#include <array>

#include "config/fields.h"
#include "daemon_config/rows.h"

namespace cansyncd {
namespace {

using namespace config::rows;  // the table reads better without the prefix in every line

constexpr auto kMetricsRows = std::to_array<DaemonRow>({
    // --- [metrics]
    field(
        [](auto& c) -> auto& { return c.metrics.file; },
        string(
            "metrics.file", OptionType::text, 0, 4096,
            "File for metrics in OpenMetrics text, for the textfile collector of node_exporter, which wants a "
            "name that ends in .prom; empty = none. A relative path starts at the configuration file's folder.")),
    duration<std::chrono::seconds>(
        [](auto& c) -> auto& { return c.metrics.period; },
        whole_number("metrics.period_s", 1, 3600, "s", "How often that file is written.")),
});

}  // namespace

std::span<const DaemonRow> rows::metrics_options() {
  return kMetricsRows;
}

}  // namespace cansyncd
