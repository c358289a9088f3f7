#include "daemon/cansync/status/metrics_desk.h"

#include <utility>

#include "daemon/cansync/status/metrics_text.h"

namespace cansyncd {

MetricsDesk::MetricsDesk(const MetricsConfig& config, MetricsFile::Tell tell) : period_(config.period) {
  if (!config.file.empty()) file_ = std::make_unique<MetricsFile>(config.file, std::move(tell));
}

std::optional<SteadyTime> MetricsDesk::step(const StatePublisher& state, const CommonStatus& common,
                                            SteadyTime now) {
  if (!file_) return std::nullopt;
  if (written_ && now - *written_ < period_) return *written_ + period_;
  written_ = now;
  const ToldStatus told = state.told();
  file_->write(metrics_text(
      {common.told(), *told.master, told.slaves, told.timing, *told.timing_snapshot, file_->failures()}));
  return now + period_;
}

}  // namespace cansyncd
