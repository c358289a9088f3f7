#include "cansync/observe/census.h"

#include <algorithm>

#include "can/frame_length.h"
#include "cansync/telegram/telegram.h"

namespace cansync::observe {
namespace {

void add_heard(HeardTelegrams& to, const can::Frame& frame) noexcept {
  ++to.count;
  to.lengths = static_cast<std::uint16_t>(to.lengths | (1u << std::min<unsigned>(frame.dlc, 8)));
}

}  // namespace

void CensusTaker::sync(Duration at, const can::Frame* frame) {
  pass(at);
  if (frame != nullptr) count(*frame);
  evidence_.sync(frame);
  ++heard_.edges;
  vote_.sync(last_);
}

void CensusTaker::frame(Duration at, const can::Frame& frame) {
  pass(at);
  count(frame);
  evidence_.frame(frame);
  if (frame.error) {
    ++heard_.error_frames;
    return;
  }
  const Decoded decoded = decode(frame);
  if (!std::holds_alternative<Telegram>(decoded)) return foreign(frame);
  vote_.frame(last_, frame);
  telegram(last_, frame);
}

void CensusTaker::begin_anew() {
  vote_.begin_anew();
  stamps_.begin_anew();
  reference_at_.reset();
}

void CensusTaker::pass(Duration at) {
  if (!first_) first_ = last_ = at;
  last_ = std::max(last_, at);
}

void CensusTaker::count(const can::Frame& frame) {
  ++heard_.frames;
  heard_.busy_bits += can::frame_bits(frame);
  stamps_.frame(last_, frame);
}

/// What its identifier says; the frame is a telegram.
void CensusTaker::telegram(Duration at, const can::Frame& frame) {
  if (frame.id == identifier::action) return add_heard(heard_.actions, frame);
  const std::uint32_t number = identifier::participant_of(frame.id);
  switch (identifier::channel_of(frame.id)) {
    case identifier::reference_one:
      return reference(at, 0, frame);
    case identifier::reference_two:
      return reference(at, 1, frame);
    default:
      break;
  }
  HeardSlave& slave = heard_.slave[number % kSlaves];
  switch (identifier::channel_of(frame.id)) {
    case identifier::actual_one:
      return add_heard(slave.actual[0], frame);
    case identifier::actual_two:
      return add_heard(slave.actual[1], frame);
    case identifier::command:
      ++slave.asked;
      return add_heard(heard_.commands, frame);
    default:
      return add_heard(slave.answers, frame);
  }
}

void CensusTaker::reference(Duration at, unsigned channel, const can::Frame& frame) {
  add_heard(heard_.reference[channel], frame);
  const std::uint32_t number = identifier::participant_of(frame.id);
  if (number < kSlaves) ++heard_.slave[number].polled[channel];
  if (channel != 0) return;
  for (std::size_t i = 0; reference_at_ && i < kSlotTimes.size(); ++i)
    if (at - *reference_at_ < kSlotTimes[i].interval / 2) ++doubles_[i];
  reference_at_ = at;
}

void CensusTaker::foreign(const can::Frame& frame) {
  const std::uint32_t identifier = frame.identifier();
  const auto length = static_cast<std::uint16_t>(1u << std::min<unsigned>(frame.dlc, 8));
  for (ForeignFrames& known : heard_.foreign) {
    if (known.identifier != identifier || known.extended != frame.extended || known.remote != frame.remote)
      continue;
    ++known.count;
    known.lengths = static_cast<std::uint16_t>(known.lengths | length);
    return;
  }
  if (heard_.foreign.size() >= kMostForeign) {
    ++heard_.foreign_over;
    return;
  }
  heard_.foreign.push_back({identifier, frame.extended, frame.remote, 1, length});
}

Census CensusTaker::census(std::optional<BitRate> bit_rate) const {
  Census out = heard_;
  out.length = first_ ? last_ - *first_ : Duration{0};
  const IntervalVote::Result vote = vote_.result();
  out.evidence = evidence_.evidence(vote);
  out.stamps = stamps_.result(bit_rate.value_or(BitRate::mbit1));
  if (!out.stamps.bunched() || vote.steady()) out.interval = vote;
  out.reference_doubles = doubles_[static_cast<unsigned>(out.interval.bit_rate)];
  return out;
}

}  // namespace cansync::observe
