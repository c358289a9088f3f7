#pragma once

#include <cstdint>
#include <string>

#include "daemon/status/common_status.h"
#include "daemon/status/metrics_text.h"

/// The metrics that every protocol has. Pure functions; not for the realtime thread.
namespace cansyncd {

/// Families of GatewayStatus, BusStatus and RealtimeStatus, and of the file itself.
MetricFamilies common_metric_families() noexcept;

/// A source with the topics that these are made of; `common` must outlive it.
MetricsSource common_metrics(const ToldCommon& common, std::uint64_t write_failures);

/// The whole file of a protocol that has one topic of its own to make `families` of.
std::string metrics_text(const ToldCommon& common, std::uint64_t write_failures, MetricTopic own,
                         MetricFamilies families);

}  // namespace cansyncd
