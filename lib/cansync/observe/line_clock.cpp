#include "cansync/observe/line_clock.h"

#include <algorithm>

#include "cansync/settings/settings.h"

namespace cansync::observe {

LineClock::LineClock(BitRate bit_rate, bool sync_seen, bool by_count) noexcept
    : times_(slot_times(bit_rate)), sync_seen_(sync_seen), by_count_(by_count) {}

void LineClock::sync(Duration at) noexcept {
  if (sync_seen_) edge(at);
}

void LineClock::reference_one(Duration at) noexcept {
  if (!sync_seen_) edge(at - (times_.reference_one - default_send_margin(times_.bit_rate)));
}

void LineClock::begin_anew() noexcept {
  edge_.reset();
  ++interval_;
}

void LineClock::edge(Duration at) noexcept {
  if (by_count_) {
    ++interval_;
  } else if (edge_ && at > *edge_) {
    const auto passed = (at - *edge_ + times_.interval / 2) / times_.interval;
    interval_ += static_cast<IntervalNumber>(std::max<Duration::rep>(passed, 0));
  }
  edge_ = at;
}

Instant LineClock::instant(Duration at) const noexcept {
  if (!edge_) return {};
  const Duration since = at - *edge_;
  if (by_count_) return {true, interval_, std::max(since, Duration{0}) % times_.interval};
  // A log has the time of its end; it may have begun before the newest edge.
  if (since < Duration{0}) return {true, interval_ - 1, std::max(times_.interval + since, Duration{0})};
  return {true, interval_ + static_cast<IntervalNumber>(since / times_.interval), since % times_.interval};
}

void SlotHistogram::add(Place place, Duration after_edge) {
  const auto at = static_cast<unsigned>(place);
  SlotUse& use = use_[at];
  if (use.count == 0) use.earliest = use.latest = after_edge;
  use.earliest = std::min(use.earliest, after_edge);
  use.latest = std::max(use.latest, after_edge);
  ++use.count;
  auto& counts = counts_[at];
  if (counts.empty()) counts.resize(kMicroseconds);
  const auto us = std::chrono::duration_cast<std::chrono::microseconds>(after_edge).count();
  ++counts[static_cast<std::size_t>(std::clamp<std::int64_t>(us, 0, kMicroseconds - 1))];
}

SlotUse SlotHistogram::use(Place place) const noexcept {
  const auto at = static_cast<unsigned>(place);
  SlotUse use = use_[at];
  const auto& counts = counts_[at];
  if (!counts.empty()) {
    const auto most = std::max_element(counts.begin(), counts.end()) - counts.begin();
    use.usual = std::chrono::microseconds(most);
  }
  return use;
}

}  // namespace cansync::observe
