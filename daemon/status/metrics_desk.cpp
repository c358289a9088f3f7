#include "daemon/status/metrics_desk.h"

#include <utility>

namespace cansyncd {

MetricsDesk::MetricsDesk(const MetricsConfig& config, MetricsFile::Tell tell, Render render)
    : period_(config.period), render_(std::move(render)) {
  if (!config.file.empty()) file_ = std::make_unique<MetricsFile>(config.file, std::move(tell));
}

std::optional<SteadyTime> MetricsDesk::step(SteadyTime now) {
  if (!file_) return std::nullopt;
  if (written_ && now - *written_ < period_) return *written_ + period_;
  written_ = now;
  file_->write(render_(file_->failures()));
  return now + period_;
}

}  // namespace cansyncd
