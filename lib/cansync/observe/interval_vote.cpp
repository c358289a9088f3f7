#include "cansync/observe/interval_vote.h"

#include <algorithm>

#include "cansync/telegram/telegram.h"

namespace cansync::observe {

void IntervalVote::sync(Duration at) noexcept {
  vote(0, at);
}

void IntervalVote::frame(Duration at, const can::Frame& frame) noexcept {
  if (!frame.is_standard_data()) return;
  switch (identifier::channel_of(frame.id)) {
    case identifier::reference_one:
      return vote(1, at);
    case identifier::reference_two:
      return vote(2, at);
    case identifier::command:
      return vote(3, at);
    default:
      break;
  }
  if (frame.id == identifier::action) vote(3, at);
}

void IntervalVote::begin_anew() noexcept {
  for (Kind& kind : kinds_) kind.last.reset();
}

void IntervalVote::vote(unsigned kind, Duration at) noexcept {
  Kind& of = kinds_[kind];
  if (of.last) {
    const Duration apart = at - *of.last;
    ++of.among;
    for (std::size_t i = 0; i < kSlotTimes.size(); ++i) {
      const Duration interval = kSlotTimes[i].interval;
      if (2 * apart < interval) ++of.too_short[i];
      const Duration off = (apart + interval / 16) % interval;
      if (apart > interval / 2 && off <= interval / 8) ++of.in_step[i];
      if (apart < interval - interval / 16 || apart > interval + interval / 16) continue;
      ++of.votes[i];
      of.sum[i] += apart;
    }
  }
  of.last = at;
}

IntervalVote::Result IntervalVote::result() const noexcept {
  Result result;
  for (unsigned k = 0; k < kKinds && result.votes == 0; ++k) {
    const Kind& kind = kinds_[k];
    std::size_t best = 0;
    std::uint64_t all = 0;
    for (std::size_t i = 0; i < kSlotTimes.size(); ++i) {
      all += kind.votes[i];
      if (kind.votes[i] > kind.votes[best]) best = i;
    }
    if (kind.votes[best] == 0) continue;
    result = {kSlotTimes[best].bit_rate,
              kind.votes[best],
              all - kind.votes[best],
              kind.among,
              kind.in_step[best],
              kind.too_short[best],
              k == 0,
              kind.sum[best] / static_cast<Duration::rep>(kind.votes[best])};
  }
  return result;
}

}  // namespace cansync::observe
