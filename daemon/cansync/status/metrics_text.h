#pragma once

#include <string>

#include "daemon/cansync/status/metrics_families.h"

namespace cansyncd {

/// The whole metrics file: OpenMetrics text that parsers of the older Prometheus text format read too. Pure
/// function; not for the realtime thread (allocates).
std::string metrics_text(const MetricsSource& from);

}  // namespace cansyncd
