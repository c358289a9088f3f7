#include "sync/clock_relation.h"

#include <algorithm>
#include <cmath>

namespace sync_line {
namespace {

/// A reading this far from the line (beside its own uncertainty) is not explained by it.
constexpr Time kUnexplained = std::chrono::microseconds(20);
constexpr unsigned kStepAfter = 3;
constexpr int kUncertainFactor = 4;
/// More uncertain readings in a row than this are the new normal, e.g. of a busier bus to the clock.
constexpr unsigned kUncertainInARow = 8;

double ns(Time time) noexcept {
  return static_cast<double>(time.count());
}

Time scaled(Time time, double factor) noexcept {
  // The whole part stays exact; only the small deviation goes through floating point.
  return time + Time(static_cast<Time::rep>(std::llround(ns(time) * (factor - 1.0))));
}

}  // namespace

Time ClockLine::to_monotonic(Time hardware_time) const noexcept {
  return monotonic + scaled(hardware_time - hardware, 1.0 / rate);
}

Time ClockLine::to_hardware(Time monotonic_time) const noexcept {
  return hardware + scaled(monotonic_time - monotonic, rate);
}

void ClockRelation::add(const ClockSample& sample) noexcept {
  if (too_uncertain(sample) && ++uncertain_ <= kUncertainInARow) return;
  uncertain_ = 0;
  if (valid()) {
    const Time error = sample.hardware - line_.to_hardware(sample.monotonic);
    if (std::chrono::abs(error) > kUnexplained + sample.uncertainty) {
      if (++unexplained_ < kStepAfter) return;
      ++steps_;
      count_ = 0;
    }
  }
  unexplained_ = 0;
  keep(sample);
  fit();
}

bool ClockRelation::too_uncertain(const ClockSample& sample) const noexcept {
  if (!valid()) return false;
  Time best = samples_[0].uncertainty;
  for (std::size_t i = 1; i < count_; ++i) best = std::min(best, samples_[i].uncertainty);
  return sample.uncertainty > std::max(best, Time(1)) * kUncertainFactor;
}

void ClockRelation::keep(const ClockSample& sample) noexcept {
  if (count_ == kKept) {
    std::copy(samples_.begin() + 1, samples_.end(), samples_.begin());
    --count_;
  }
  samples_[count_++] = sample;
}

void ClockRelation::fit() noexcept {
  const ClockSample& anchor = samples_[count_ - 1];
  double sum_x = 0;
  double sum_y = 0;
  double sum_xx = 0;
  double sum_xy = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double x = ns(samples_[i].monotonic - anchor.monotonic);
    const double y = ns(samples_[i].hardware - anchor.hardware) - x;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const auto n = static_cast<double>(count_);
  const double spread = n * sum_xx - sum_x * sum_x;
  const double slope = spread > 0 ? (n * sum_xy - sum_x * sum_y) / spread : 0;
  const double offset = (sum_y - slope * sum_x) / n;
  line_.monotonic = anchor.monotonic;
  line_.hardware = anchor.hardware + Time(static_cast<Time::rep>(std::llround(offset)));
  line_.rate = 1 + slope;
}

}  // namespace sync_line
