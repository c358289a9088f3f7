#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "daemon/cansync/status/gateway_state.h"
#include "daemon/status/common_status.h"
#include "daemon/status/metrics_text.h"

/// What the metrics file of a master holds beside what every protocol has. Pure functions; not for the
/// realtime thread (allocates).
namespace cansyncd {

/// The order of `cansync_Timing.slot`.
inline constexpr std::array<std::string_view, 6> kSlotNames = {"RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"};

/// Labels of a slave's samples.
std::string slave_labels(const cansync_SlaveStatus& slave);

/// Families of MasterStatus, SlaveStatus and Timing, in the order of the file.
MetricFamilies master_metric_families() noexcept;

/// The whole file, of what was told last.
std::string master_metrics_text(const ToldCommon& common, const ToldStatus& told,
                                std::uint64_t write_failures);

}  // namespace cansyncd
