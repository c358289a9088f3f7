#pragma once

#include <cstdint>
#include <string>

#include "daemon/status/common_status.h"
#include "daemon/status/metrics_text.h"
#include "layer2.h"

/// What the metrics file of a bus of general frames holds beside what every protocol has. Pure functions; not
/// for the realtime thread (allocates).
namespace cansyncd {

/// Families of FrameStatus, in the order of the file.
MetricFamilies frame_metric_families() noexcept;

/// The whole file, of what was told last.
std::string frame_metrics_text(const ToldCommon& common, const layer2_FrameStatus& told,
                               std::uint64_t write_failures);

}  // namespace cansyncd
