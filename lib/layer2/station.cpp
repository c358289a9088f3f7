#include "layer2/station.h"

#include <algorithm>
#include <utility>

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

/// The bits of the arbitration field: of two frames that begin at once the smaller number wins.
std::uint32_t arbitration(const can::Frame& frame) noexcept {
  const std::uint32_t id = frame.identifier();
  const std::uint32_t remote = frame.remote ? 1 : 0;
  if (!frame.extended) return id << 21 | remote << 20;
  return (id >> 18) << 21 | 3u << 19 | (id & 0x3FFFF) << 1 | remote;
}

}  // namespace

Outcome outcome_of(JobKnown known, JobEnd end) noexcept {
  switch (can::ending_of(known, end)) {
    case can::JobEnding::timeout:
      return Outcome::timeout;
    case can::JobEnding::cancelled:
      return Outcome::cancelled;
    case can::JobEnding::stopped:
      return Outcome::stopped;
    case can::JobEnding::no_answer:
    case can::JobEnding::lost:
    case can::JobEnding::taken:
      break;
  }
  return Outcome::no_answer;
}

Station::Station(const StationSettings& settings)
    : filter_(settings.filter),
      node_(settings.node),
      normal_(std::min<std::size_t>(settings.queue, kMostQueue), settings.overflow, kMostQueue),
      high_(std::min<std::size_t>(settings.high_queue, kMostQueue), settings.overflow, kMostQueue),
      answers_(2 * kMostQueue + kMostHandedOver + kMostDisplaced) {}

void Station::set(const StationSettings& settings) noexcept {
  filter_ = settings.filter;
  node_ = settings.node;
  normal_.set(settings.queue, settings.overflow);
  high_.set(settings.high_queue, settings.overflow);
}

std::optional<std::uint8_t> Station::receive(const can::Frame& frame) noexcept {
  std::optional<std::uint8_t> range;
  if (!node_) {
    range = filter_.match(frame);
  } else if (takes(*node_, frame)) {
    range = 0;
  }
  count_received();
  if (range) ++counters_.taken;
  return range;
}

Priority Station::priority_of(std::uint8_t range) const noexcept {
  return !node_ && filter_.range(range).high_priority ? Priority::high : Priority::normal;
}

Refusal Station::submit(const SendOrder& order, Time now) noexcept {
  if (stopped_) return Refusal::stopped;
  if (order.timeout <= Time{0}) return Refusal::too_late;
  if (!can_be_sent(order.frame) || order.following.size() > SendOrder::kMostFollowing ||
      !std::all_of(order.following.begin(), order.following.end(), can_be_sent))
    return Refusal::bad_frame;
  // Each open order has room for its answer.
  if (open() >= answers_.depth()) return Refusal::queue_full;
  if (waiting() == 0) obstacle_ = Obstacle::none;
  BoundedQueue<Open>& queue = queue_of(order.priority);
  Open taken{order.id, as_on_the_bus(order.frame), now + order.timeout};
  taken.more = order.following;
  taken.frames = static_cast<std::uint8_t>(order.following.size() + 1);
  std::size_t at = queue.size();
  if (order.placing == Placing::by_identifier) {
    at = std::min<std::size_t>(1, queue.size());
    while (at < queue.size() && arbitration(queue[at].frame) <= arbitration(taken.frame)) ++at;
  }
  const auto pushed = queue.insert(at, taken);
  if (pushed.deleted) end_waiting(*pushed.deleted, Outcome::displaced);
  if (pushed.taken) ++submitted_;
  return pushed.taken ? Refusal::none : Refusal::queue_full;
}

bool Station::cancel(OrderId id) noexcept {
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    for (std::size_t i = 0; i < queue->size(); ++i) {
      if ((*queue)[i].id != id) continue;
      end_waiting((*queue)[i], outcome_of(JobKnown::not_sent, JobEnd::cancelled));
      queue->erase(i);
      return true;
    }
  }
  return false;
}

void Station::clear_queues() noexcept {
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    while (!queue->empty()) end_waiting(queue->pop(), Outcome::deleted);
  }
}

void Station::reset_overflow() noexcept {
  normal_.reset_overflow();
  high_.reset_overflow();
}

Station::QueueState Station::queue(Priority priority) const noexcept {
  const BoundedQueue<Open>& queue = priority == Priority::high ? high_ : normal_;
  return {static_cast<std::uint16_t>(queue.size()), static_cast<std::uint16_t>(queue.depth()),
          queue.half_full(), queue.overflowed(), queue.lost()};
}

std::optional<can::Frame> Station::next_frame(bool normal, bool high) noexcept {
  if (handed_over_.full()) return std::nullopt;
  if (high && !high_.empty()) {
    offered_ = Priority::high;
    return high_[0].frame;
  }
  if (!normal || normal_.empty()) {
    if (waiting() != 0 && obstacle_ == Obstacle::none) obstacle_ = Obstacle::window_closed;
    return std::nullopt;
  }
  offered_ = Priority::normal;
  return normal_[0].frame;
}

void Station::handed_over() noexcept {
  BoundedQueue<Open>& queue = queue_of(offered_);
  if (queue.empty() || handed_over_.full()) return;
  obstacle_ = Obstacle::none;
  Open& first = queue[0];
  if (first.more.empty()) {
    handed_over_.push(queue.pop());
    return;
  }
  Open piece{first.id, first.frame, Time::max()};
  piece.answered = piece.piece = true;
  handed_over_.push(piece);
  first.frame = as_on_the_bus(first.more.front());
  first.more = first.more.subspan(1);
}

/// Ends an order that waits. What of it is in the controller is waited for, so that its answer can say how
/// much was sent.
void Station::end_waiting(const Open& order, Outcome outcome) noexcept {
  std::uint8_t pieces = 0;
  Open* last = nullptr;
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    if (!handed_over_[i].piece || handed_over_[i].id != order.id) continue;
    ++pieces;
    last = &handed_over_[i];
  }
  if (last == nullptr) return end(order, outcome);
  const can::Frame frame = last->frame;
  *last = order;
  last->frame = frame;
  last->more = {};
  last->frames = static_cast<std::uint8_t>(order.seen + pieces);
  last->ends_as = outcome;
}

void Station::own_handed_over(const can::Frame& frame, const OwnFrame& own) noexcept {
  if (handed_over_.full()) return;
  handed_over_.push({0, as_on_the_bus(frame), Time::max(), own, true});
}

void Station::held_back(Obstacle obstacle) noexcept {
  obstacle_ = obstacle;
}

std::optional<OwnFrame> Station::echo(const can::Frame& frame, Time end_of_frame) noexcept {
  ++counters_.sent;
  std::size_t found = 0;
  while (found < handed_over_.size() && handed_over_[found].frame != frame) ++found;
  if (found == handed_over_.size()) return std::nullopt;
  const Open sent = handed_over_[found];
  handed_over_.erase(found);
  seen(sent, end_of_frame);
  overtake(found);
  return sent.own;
}

/// A frame that was handed over stood on the bus.
void Station::seen(const Open& frame, Time end_of_frame) noexcept {
  if (!frame.piece) {
    if (frame.answered) return;
    Open order = frame;
    const bool all = ++order.seen == order.frames;
    return end(order, all ? order.ends_as : Outcome::no_answer, end_of_frame);
  }
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    for (std::size_t i = 0; i < queue->size(); ++i) {
      if ((*queue)[i].id == frame.id) ++(*queue)[i].seen;
    }
  }
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    if (handed_over_[i].id == frame.id && !handed_over_[i].piece) ++handed_over_[i].seen;
  }
}

/// A piece is gone from the controller, and may have been sent: nothing is sent behind the gap.
void Station::lose_piece(OrderId id) noexcept {
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    for (std::size_t i = queue->size(); i-- > 0;) {
      if ((*queue)[i].id != id) continue;
      end((*queue)[i], outcome_of(JobKnown::handed_over, JobEnd::unanswered));
      queue->erase(i);
    }
  }
}

void Station::echoes_lost() noexcept {
  overtake(handed_over_.size());
}

/// The `count` frames handed over first keep their places until they are answered, and no longer.
void Station::overtake(std::size_t count) noexcept {
  for (std::size_t i = 0, looked_at = 0; looked_at < count; ++looked_at) {
    Open& frame = handed_over_[i];
    frame.overtaken = true;
    if (!frame.answered) {
      ++i;
      continue;
    }
    if (frame.own.sender != Sender::order && !lost_.full()) lost_.push(frame.own);
    handed_over_.erase(i);
  }
}

can::BoundedList<OwnFrame, Station::kMostHandedOver> Station::take_lost() noexcept {
  return std::exchange(lost_, {});
}

void Station::controller_emptied() noexcept {
  while (handed_over_.size() != 0) {
    const Open frame = handed_over_[0];
    handed_over_.erase(0);
    if (frame.piece) lose_piece(frame.id);
    if (!frame.answered) end(frame, outcome_of(JobKnown::handed_over, JobEnd::unanswered));
  }
}

void Station::advance(Time now) noexcept {
  end_handed_over(now);
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    for (std::size_t i = 0; i < queue->size();) {
      if ((*queue)[i].until <= now) {
        const Open order = (*queue)[i];
        queue->erase(i);
        end_waiting(order, outcome_of(JobKnown::not_sent, JobEnd::time));
      } else {
        ++i;
      }
    }
  }
  end_handed_over(now);  // of several frames, whose order waited
}

/// Answers what has waited too long for its echo, and forgets what is neither waited for nor in the way.
void Station::end_handed_over(Time now) noexcept {
  for (std::size_t i = 0; i < handed_over_.size();) {
    Open& order = handed_over_[i];
    if (!order.answered && order.until <= now) {
      end(order, outcome_of(JobKnown::handed_over, JobEnd::time));
      order.answered = true;
    }
    if (order.answered && order.overtaken) {
      handed_over_.erase(i);
    } else {
      ++i;
    }
  }
}

Time Station::next_deadline() const noexcept {
  Time next = Time::max();
  for (const BoundedQueue<Open>* queue : {&high_, &normal_}) {
    for (std::size_t i = 0; i < queue->size(); ++i) next = std::min(next, (*queue)[i].until);
  }
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    if (!handed_over_[i].answered) next = std::min(next, handed_over_[i].until);
  }
  return next;
}

std::optional<Answer> Station::take_answer() noexcept {
  if (answers_.empty()) return std::nullopt;
  return answers_.pop();
}

void Station::stop() noexcept {
  stopped_ = true;
  controller_emptied();
  for (BoundedQueue<Open>* queue : {&high_, &normal_}) {
    while (!queue->empty()) end(queue->pop(), outcome_of(JobKnown::not_sent, JobEnd::stopped));
  }
}

void Station::end(const Open& order, Outcome outcome, Time sent) noexcept {
  const Obstacle obstacle = outcome == Outcome::timeout ? obstacle_ : Obstacle::none;
  (void)answers_.push({order.id, outcome, sent, obstacle, order.seen});
  if (outcome == Outcome::no_answer) ++counters_.unanswered;
  if (outcome != Outcome::no_answer && outcome != Outcome::done) ++counters_.not_sent;
}

}  // namespace layer2
