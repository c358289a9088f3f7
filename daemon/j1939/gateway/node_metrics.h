#pragma once

#include <cstdint>
#include <string>

#include "daemon/status/common_status.h"
#include "daemon/status/metrics_text.h"
#include "j1939.h"

/// What the metrics file of a node of J1939 holds beside what every protocol has. Pure functions; not for
/// the realtime thread (allocates).
namespace cansyncd {

/// Families of NodeStatus, in the order of the file.
MetricFamilies node_metric_families() noexcept;

/// The whole file, of what was told last.
std::string node_metrics_text(const ToldCommon& common, const j1939_NodeStatus& told,
                              std::uint64_t write_failures);

}  // namespace cansyncd
