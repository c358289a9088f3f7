#include "cansync/slave/slave_supervision.h"

#include <algorithm>
#include <limits>

namespace cansync {

SlaveSupervision::SlaveSupervision(const SlaveSupervisionSettings& settings) noexcept
    : interval_(settings.interval),
      on_time_(settings.interval + settings.interval / 2),
      // n missing edges: the next one comes n + 1 intervals after the last.
      silence_(settings.interval * (std::max(settings.edges_until_fault, 2u) + 1LL) - settings.interval / 2),
      lock_time_(settings.lock_time),
      misses_until_fault_(settings.misses_until_fault),
      on_sync_lost_(settings.on_sync_lost),
      on_references_missing_(settings.on_references_missing) {}

std::uint32_t SlaveSupervision::edge(Duration now, bool activated) noexcept {
  const Duration elapsed = now - last_;
  std::uint32_t intervals = 1;
  if (!seen_ || elapsed < interval_ / 2) {
    intervals = 0;
  } else if (elapsed >= on_time_) {
    const auto rounded = (elapsed + interval_ / 2) / interval_;
    intervals =
        static_cast<std::uint32_t>(std::min<std::int64_t>(rounded, std::numeric_limits<std::int32_t>::max()));
    missed_edges_ += intervals - 1;
    if (elapsed > silence_) lose();
  }
  seen_ = true;
  last_ = now;
  if (!activated) {
    synchronized_ = false;
    locking_ = false;
  } else if (!locking_) {
    locking_ = true;
    locking_since_ = now;
  }
  if (locking_ && !synchronized_) synchronized_ = now - locking_since_ >= lock_time_;
  return intervals;
}

void SlaveSupervision::lose() noexcept {
  if (synchronized_) raise(SlaveFault::sync_lost);
  synchronized_ = false;
  locking_ = false;
}

std::uint32_t SlaveSupervision::references(std::uint32_t intervals, bool fresh) noexcept {
  std::uint32_t missing = std::min(intervals, kMostMissing);
  if (fresh && missing > 0) --missing;
  if (!reference_seen_) missing = 0;
  missed_references_ += missing;
  misses_ += missing;
  extrapolating_ = !fresh && misses_ > 0;
  if (fresh) {
    reference_seen_ = true;
    misses_ = 0;
  } else if (misses_until_fault_ != 0 && misses_ >= misses_until_fault_) {
    raise(SlaveFault::references_missing);
    forget_references();
  }
  return missing;
}

void SlaveSupervision::forget_references() noexcept {
  reference_seen_ = false;
  extrapolating_ = false;
  misses_ = 0;
}

void SlaveSupervision::raise(SlaveFault fault) noexcept {
  news_.add(fault);
  standing_.add(fault);
}

SlaveFault SlaveSupervision::take_fault() noexcept {
  const SlaveFault found = news_.graver();
  news_.remove(found);
  return found;
}

SlaveReaction SlaveSupervision::reaction() const noexcept {
  SlaveReaction strongest = SlaveReaction::report;
  for (const SlaveFault fault : {SlaveFault::sync_lost, SlaveFault::references_missing}) {
    if (stands(fault)) strongest = std::max(strongest, reaction_to(fault));
  }
  return strongest;
}

SlaveReaction SlaveSupervision::reaction_to(SlaveFault fault) const noexcept {
  switch (fault) {
    case SlaveFault::sync_lost:
      return on_sync_lost_;
    case SlaveFault::references_missing:
      return on_references_missing_;
    case SlaveFault::none:
      break;
  }
  return SlaveReaction::report;
}

void SlaveSupervision::reset() noexcept {
  seen_ = false;
  locking_ = false;
  synchronized_ = false;
  standing_ = {};
  news_ = {};
  missed_references_ = 0;
  forget_references();
}

}  // namespace cansync
