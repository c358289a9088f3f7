#include "sync/phase_lock.h"

#include <algorithm>
#include <cmath>

namespace sync_line {
namespace {

// Parts of an interval.
constexpr double kNear = 1.0 / 20;     ///< phase errors below are filtered, those above approached
constexpr double kOutlier = 1.0 / 10;  ///< locked: edges further off are not used
constexpr double kGood = 1.0 / 100;    ///< mean error below which the timeline counts as locked

/// The frequency takes at most half of the greatest step, so that phase can still be corrected.
constexpr double kFrequencyPart = 0.5;

/// Edges missing in a row until holdover begins.
constexpr std::uint64_t kMissing = 2;

/// Damping 0.7 each. Few edges (one a second) have to be worth more than many.
struct Tuning {
  double wide_proportional;
  double wide_integral;
  double proportional;
  double integral;
  double mean_weight;      ///< of a new edge in the mean error
  std::uint32_t good;      ///< edges in a row until locked
  std::uint32_t outliers;  ///< edges in a row until the search begins again
};
constexpr Tuning kDense = {0.25, 0.03, 0.05, 0.00125, 1.0 / 8, 16, 16};
constexpr Tuning kSparse = {0.7, 0.25, 0.3, 0.045, 1.0 / 2, 3, 3};

constexpr const Tuning& tuning(std::uint32_t spacing) noexcept {
  return spacing > 1 ? kSparse : kDense;
}

double nanoseconds(Time time) noexcept {
  return static_cast<double>(time.count());
}

}  // namespace

PhaseLock::PhaseLock(const PhaseLockSettings& settings) noexcept
    : settings_(settings),
      interval_(nanoseconds(settings.interval)),
      step_(nanoseconds(settings.greatest_step)) {}

void PhaseLock::begin(Time next) noexcept {
  next_ = next;
  fraction_ = frequency_ = share_ = 0;
  share_left_ = since_accepted_ = 0;
  state_ = LockState::searching;
  any_accepted_ = any_seen_ = slewing_ = false;
  slew_target_ = mean_error_ = outlier_error_ = 0;
  good_ = outliers_ = 0;
  counters_ = {};
}

double PhaseLock::period() const noexcept {
  return interval_ + frequency_;
}

Time PhaseLock::holdover() const noexcept {
  if (state_ != LockState::holdover && state_ != LockState::lost) return Time{0};
  return Time(static_cast<Time::rep>(since_accepted_) * settings_.interval.count());
}

void PhaseLock::advance(std::uint64_t n) noexcept {
  const auto count = static_cast<double>(n);
  const std::uint64_t shared = std::min(n, share_left_);
  const double wanted = frequency_ * count + share_ * static_cast<double>(shared);
  share_left_ -= shared;
  const double moved = std::clamp(wanted, -step_ * count, step_ * count) + fraction_;
  const double whole = std::floor(moved);
  fraction_ = moved - whole;
  next_ += settings_.interval * static_cast<Time::rep>(n) + Time(static_cast<Time::rep>(whole));
  if (!any_accepted_) return;
  since_accepted_ += n;
  const std::uint64_t until_holdover = kMissing * settings_.spacing;
  if (state_ == LockState::locked && since_accepted_ > until_holdover) state_ = LockState::holdover;
  if (state_ == LockState::lost || since_accepted_ <= until_holdover) return;
  const auto limit = static_cast<std::uint64_t>(settings_.holdover / settings_.interval);
  if (since_accepted_ - until_holdover > limit) state_ = LockState::lost;
}

/// Distance from the nearest edge of the timeline, in ns.
double PhaseLock::error_of(Time at) const noexcept {
  const double distance = nanoseconds(at - next_) - fraction_;
  return distance - std::round(distance / period()) * period();
}

void PhaseLock::input(Time at) noexcept {
  const bool in_order = !any_seen_ || at > last_seen_;
  const Time least = settings_.interval * settings_.spacing / 2;
  if (!in_order || (any_accepted_ && at - last_accepted_ < least)) {
    ++counters_.rejected;
    return;
  }
  any_seen_ = true;
  last_seen_ = at;
  if (state_ == LockState::lost) {
    state_ = LockState::searching;
    good_ = 0;
  }
  if (tracking()) {
    track(at, error_of(at));
  } else {
    search(at, error_of(at));
  }
}

void PhaseLock::track(Time at, double error) noexcept {
  if (std::abs(error) > interval_ * kOutlier) {
    ++counters_.rejected;
    set_outlier(error);
    return;
  }
  outliers_ = 0;
  const Tuning& tune = tuning(settings_.spacing);
  mean_error_ += tune.mean_weight * (error - mean_error_);
  filter(error, {tune.proportional, tune.integral});
  state_ = LockState::locked;
  accept(at);
}

/// Edges that agree with each other are the input after a jump, others are disturbances.
void PhaseLock::set_outlier(double error) noexcept {
  const double apart = std::abs(std::remainder(error - outlier_error_, interval_));
  outliers_ = outliers_ > 0 && apart < interval_ * kNear ? outliers_ + 1 : 1;
  outlier_error_ = error;
  if (outliers_ < tuning(settings_.spacing).outliers) return;
  state_ = LockState::searching;
  outliers_ = good_ = 0;
  slewing_ = false;
}

void PhaseLock::search(Time at, double error) noexcept {
  const Tuning& tune = tuning(settings_.spacing);
  if (settings_.spacing > 1) learn_period(at);
  // At half an interval both directions are as near; noise must not turn the movement round.
  const bool turned = slewing_ && error * slew_target_ < 0 && std::abs(error) > interval_ / 4;
  if (turned) error += std::copysign(interval_, slew_target_);
  if (std::abs(error) > interval_ * kNear) {
    // One among near ones is a disturbance; when most are far off, the search begins again.
    if (good_ > 0) {
      --good_;
      ++counters_.rejected;
      return;
    }
    slew(error);
    accept(at);
    return;
  }
  slewing_ = false;
  mean_error_ = good_ == 0 ? error : mean_error_ + tune.mean_weight * (error - mean_error_);
  good_ += 1;
  filter(error, {tune.wide_proportional, tune.wide_integral});
  if (good_ >= tune.good && std::abs(mean_error_) <= interval_ * kGood) state_ = LockState::locked;
  accept(at);
}

/// The phase is approached as fast as it may be.
void PhaseLock::slew(double error) noexcept {
  slewing_ = true;
  good_ = 0;
  mean_error_ = error;
  share_left_ = static_cast<std::uint64_t>(std::max(std::ceil(std::abs(error) / step_), 1.0));
  share_ = error / static_cast<double>(share_left_);
  // The next edge measures anew; what is still to do then keeps its direction.
  const double until_then =
      share_ * static_cast<double>(std::min<std::uint64_t>(share_left_, settings_.spacing));
  slew_target_ = error - until_then;
}

/// Between two edges far apart the phase may drift further than `kNear`: their distance tells the period.
void PhaseLock::learn_period(Time at) noexcept {
  if (!any_accepted_) return;
  const double distance = nanoseconds(at - last_accepted_);
  const double intervals = std::round(distance / interval_);
  const double deviation = distance / intervals - interval_;
  if (std::abs(deviation) <= step_ * kFrequencyPart) frequency_ = deviation;
}

void PhaseLock::filter(double error, const Gains& gains) noexcept {
  const auto spacing = static_cast<double>(settings_.spacing);
  share_ = gains.proportional * error / spacing;
  share_left_ = settings_.spacing;
  // Beyond the greatest step the error says nothing about the frequency.
  if (std::abs(share_) > step_) return;
  const auto since = static_cast<double>(std::max<std::uint64_t>(since_accepted_, settings_.spacing));
  const double limit = step_ * kFrequencyPart;
  frequency_ = std::clamp(frequency_ + gains.integral * error / since, -limit, limit);
}

void PhaseLock::accept(Time at) noexcept {
  ++counters_.accepted;
  any_accepted_ = true;
  last_accepted_ = at;
  since_accepted_ = 0;
}

const char* name(LockState state) noexcept {
  switch (state) {
    case LockState::searching:
      return "searching";
    case LockState::locked:
      return "locked";
    case LockState::holdover:
      return "holdover";
    case LockState::lost:
      return "lost";
  }
  return "unknown";
}

}  // namespace sync_line
