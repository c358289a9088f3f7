#include "cansync/process_data/reference_check.h"

namespace cansync {
namespace {

/// Rounding of scaled limits; numbers are whole.
constexpr double kRounding = 1e-6;

}  // namespace

void ReferenceCheck::note_limited() noexcept {
  limited_ = 0;
  for (unsigned v = 0; v < kValues; ++v) limited_ |= limits_[v].any() ? 1u << v : 0u;
}

void ReferenceCheck::set_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept {
  limits_[value] = limits;
  note_limited();
}

std::optional<LimitViolation> ReferenceCheck::judge(Channel channel, CarriedValues carried,
                                                    const Values& values, IntervalNumber now,
                                                    const ActualSource& actual) const noexcept {
  const unsigned limited = carried.values & limited_;
  for (std::uint8_t v = 0; limited >> v != 0; ++v) {
    if (((limited >> v) & 1u) == 0) continue;
    const std::int64_t number = number_of(values[v], ((carried.words >> v) & 1u) != 0, limits_[v].is_signed);
    if (const auto beyond = out_of_range(v, number)) return beyond;
    if (const auto beyond = too_far(v, number, withdrawn_[index(channel)], now, actual)) return beyond;
  }
  return std::nullopt;
}

std::optional<LimitViolation> ReferenceCheck::judge_range(CarriedValues carried,
                                                          const Values& values) const noexcept {
  const unsigned limited = carried.values & limited_;
  for (std::uint8_t v = 0; limited >> v != 0; ++v) {
    if (((limited >> v) & 1u) == 0) continue;
    const std::int64_t number = number_of(values[v], ((carried.words >> v) & 1u) != 0, limits_[v].is_signed);
    if (const auto beyond = out_of_range(v, number)) return beyond;
  }
  return std::nullopt;
}

std::optional<LimitViolation> ReferenceCheck::out_of_range(std::uint8_t value,
                                                           std::int64_t number) const noexcept {
  const ReferenceLimits& limits = limits_[value];
  if (number < limits.minimum) return LimitViolation{LimitKind::minimum, value, number, 0, limits.minimum};
  if (number > limits.maximum) return LimitViolation{LimitKind::maximum, value, number, 0, limits.maximum};
  return std::nullopt;
}

std::optional<LimitViolation> ReferenceCheck::too_far(std::uint8_t value, std::int64_t number, bool withdrawn,
                                                      IntervalNumber now,
                                                      const ActualSource& actual) const noexcept {
  const ReferenceLimits& limits = limits_[value];
  const Sent& last = sent_[value];
  const bool follows = last.known && now - last.interval <= kContinues;
  if (last.known && (follows || !limits.start_within)) {
    const std::int64_t before = number_of(last.raw, last.word, limits.is_signed);
    const std::int64_t step = number > before ? number - before : before - number;
    if (step > limits.max_step)
      return LimitViolation{LimitKind::max_step, value, number, before, limits.max_step};
  }
  if (!limits.start_within || (follows && !withdrawn)) return std::nullopt;
  const StartWithin& start = *limits.start_within;
  const auto seen = actual.recent(start.slave, start.value);
  if (!seen) return LimitViolation{LimitKind::start_unknown, value, number, 0, 0};
  const std::int64_t there = number_of(seen->raw, seen->word, start.is_signed);
  const double wanted = static_cast<double>(there) * start.factor + start.offset;
  const double away = static_cast<double>(number) - wanted;
  const double most = start.distance + kRounding;
  if (away <= most && -away <= most) return std::nullopt;
  return LimitViolation{LimitKind::start_within, value, number, there, 0};
}

void ReferenceCheck::sent(CarriedValues carried, const Values& values, IntervalNumber now) noexcept {
  for (unsigned v = 0; unsigned{carried.values} >> v != 0; ++v) {
    if (((carried.values >> v) & 1u) != 0)
      sent_[v] = {true, ((carried.words >> v) & 1u) != 0, values[v], now};
  }
}

}  // namespace cansync
