#include "layer2/station.h"

#include <algorithm>

namespace layer2 {
namespace {

bool can_be_sent(const can::Frame& frame) noexcept {
  if (frame.error || frame.dlc > frame.data.size()) return false;
  return frame.id <= (frame.extended ? can::kExtendedIdentifierMask : can::kStandardIdentifierMask);
}

/// As the bus gives it back: what is not sent is zero.
can::Frame as_on_the_bus(can::Frame frame) noexcept {
  const std::size_t bytes = frame.remote ? 0 : frame.dlc;
  for (std::size_t i = bytes; i < frame.data.size(); ++i) frame.data[i] = 0;
  return frame;
}

}  // namespace

Station::Station(const StationSettings& settings) noexcept
    : filter_(settings.filter), queue_(std::clamp<std::size_t>(settings.queue, 1, kMostQueue)) {}

std::optional<std::uint8_t> Station::receive(const can::Frame& frame) noexcept {
  ++counters_.received;
  const auto range = filter_.match(frame);
  if (range) ++counters_.taken;
  return range;
}

Refusal Station::submit(const SendOrder& order, Time now) noexcept {
  if (stopped_) return Refusal::stopped;
  if (!can_be_sent(order.frame)) return Refusal::bad_frame;
  // Each open order has room for its answer.
  if (waiting_.size() >= queue_ || open() >= kMostQueue + kMostHandedOver) return Refusal::queue_full;
  if (waiting_.size() == 0) obstacle_ = Obstacle::none;
  waiting_.push({order.id, as_on_the_bus(order.frame), now + order.timeout});
  return Refusal::none;
}

bool Station::cancel(OrderId id) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (waiting_[i].id != id) continue;
    end(waiting_[i], Outcome::cancelled);
    waiting_.erase(i);
    return true;
  }
  return false;
}

std::optional<can::Frame> Station::next_frame() const noexcept {
  if (waiting_.size() == 0 || handed_over_.full()) return std::nullopt;
  return waiting_[0].frame;
}

void Station::handed_over() noexcept {
  if (waiting_.size() == 0 || handed_over_.full()) return;
  handed_over_.push(waiting_[0]);
  waiting_.erase(0);
  obstacle_ = Obstacle::none;
}

void Station::held_back(Obstacle obstacle) noexcept {
  obstacle_ = obstacle;
}

void Station::echo(const can::Frame& frame, Time end_of_frame) noexcept {
  ++counters_.sent;
  std::size_t found = 0;
  while (found < handed_over_.size() && handed_over_[found].frame != frame) ++found;
  if (found == handed_over_.size()) return;
  if (!handed_over_[found].answered) end(handed_over_[found], Outcome::done, end_of_frame);
  handed_over_.erase(found);
  overtake(found);
}

void Station::echoes_lost() noexcept {
  overtake(handed_over_.size());
}

/// The `count` frames handed over first keep their places until they are answered, and no longer.
void Station::overtake(std::size_t count) noexcept {
  for (std::size_t i = count; i-- > 0;) {
    handed_over_[i].overtaken = true;
    if (handed_over_[i].answered) handed_over_.erase(i);
  }
}

void Station::controller_emptied() noexcept {
  while (handed_over_.size() != 0) {
    if (!handed_over_[0].answered) end(handed_over_[0], Outcome::no_answer);
    handed_over_.erase(0);
  }
}

void Station::advance(Time now) noexcept {
  for (std::size_t i = 0; i < handed_over_.size();) {
    Open& order = handed_over_[i];
    if (!order.answered && order.until <= now) {
      end(order, Outcome::no_answer);
      order.answered = true;
    }
    if (order.answered && order.overtaken) {
      handed_over_.erase(i);
    } else {
      ++i;
    }
  }
  for (std::size_t i = 0; i < waiting_.size();) {
    if (waiting_[i].until <= now) {
      end(waiting_[i], Outcome::timeout);
      waiting_.erase(i);
    } else {
      ++i;
    }
  }
}

Time Station::next_deadline() const noexcept {
  Time next = Time::max();
  for (std::size_t i = 0; i < waiting_.size(); ++i) next = std::min(next, waiting_[i].until);
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    if (!handed_over_[i].answered) next = std::min(next, handed_over_[i].until);
  }
  return next;
}

std::optional<Answer> Station::take_answer() noexcept {
  if (answers_.size() == 0) return std::nullopt;
  const Answer answer = answers_[0];
  answers_.erase(0);
  return answer;
}

void Station::stop() noexcept {
  stopped_ = true;
  controller_emptied();
  for (; waiting_.size() != 0; waiting_.erase(0)) end(waiting_[0], Outcome::stopped);
}

void Station::end(const Open& order, Outcome outcome, Time sent) noexcept {
  const Obstacle obstacle = outcome == Outcome::timeout ? obstacle_ : Obstacle::none;
  answers_.push({order.id, outcome, sent, obstacle});
  if (outcome == Outcome::no_answer) ++counters_.unanswered;
  if (outcome != Outcome::no_answer && outcome != Outcome::done) ++counters_.not_sent;
}

}  // namespace layer2
