#pragma once

#include <cstdint>
#include <string>

#include "cansync_slave.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_text.h"

/// What the metrics file of a slave holds beside what every protocol has. Pure functions; not for the
/// realtime thread (allocates).
namespace cansyncd {

/// Families of SlaveSideStatus, in the order of the file.
MetricFamilies slave_metric_families() noexcept;

/// The whole file, of what was told last.
std::string slave_metrics_text(const ToldCommon& common, const cansync_slave_SlaveSideStatus& told,
                               std::uint64_t write_failures);

}  // namespace cansyncd
