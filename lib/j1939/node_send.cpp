#include <algorithm>

#include "j1939/node.h"

namespace j1939 {

can::Frame Node::frame_for(const Order& order, Address source) const noexcept {
  can::Frame frame;
  frame.extended = true;
  if (order.kind == OrderKind::request) {
    frame.id = compose(identifier_of(pgn::kRequest, order.priority, order.destination, source));
    frame.dlc = 3;
    for (unsigned i = 0; i < 3; ++i) frame.data[i] = static_cast<std::uint8_t>(order.number >> 8 * i);
    return frame;
  }
  frame.id = compose(identifier_of(order.number, order.priority, order.destination, source));
  frame.dlc = static_cast<std::uint8_t>(order.memory.size());
  std::copy(order.memory.begin(), order.memory.end(), frame.data.begin());
  return frame;
}

std::optional<can::Frame> Node::next_frame() noexcept {
  offer_.reset();
  if (handed_over_.full()) return std::nullopt;
  if (const auto frame = claim_.next_frame()) {
    offer_ = Offer{Owner::claim, 0, *frame};
    return *frame;
  }
  if (const auto frame = replies_.front(); frame && claim_.address()) {
    offer_ = Offer{Owner::reply, 0, *frame};
    return *frame;
  }
  // As on the bus: the lowest identifier goes first, of equal ones the older order.
  const auto consider = [&](Owner owner, std::size_t index, const can::Frame& frame) {
    if (!offer_ || frame.id < offer_->frame.id) offer_ = Offer{owner, index, frame};
  };
  const auto address = claim_.address();
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const Order& order = waiting_[i].order;
    if (is_long(order)) continue;
    if (address) {
      consider(Owner::order, i, frame_for(order, *address));
    } else if (wants_claims_of_all(order)) {
      consider(Owner::order, i, frame_for(order, kNullAddress));
    }
  }
  for (std::size_t i = 0; address && i < TransportSender::kSessions; ++i) {
    if (const auto frame = sender_.next_frame(i)) consider(Owner::session, i, *frame);
  }
  return offer_ ? std::optional(offer_->frame) : std::nullopt;
}

void Node::handed_over() noexcept {
  if (!offer_ || handed_over_.full()) return;
  const Offer offer = *offer_;
  offer_.reset();
  obstacle_ = Obstacle::none;
  HandedOver entry;
  entry.frame = offer.frame;
  entry.owner = offer.owner;
  switch (offer.owner) {
    case Owner::claim:
      claim_.handed_over();
      break;
    case Owner::reply:
      replies_.pop();
      break;
    case Owner::order:
      entry.open = waiting_[offer.index];
      waiting_.erase(offer.index);
      break;
    case Owner::session:
      entry.session = offer.index;
      entry.id = sender_.job_at(offer.index);
      sender_.handed_over(offer.index, now_);
      break;
  }
  handed_over_.push(entry);
}

/// What follows from a frame that stood on the bus.
void Node::seen(const HandedOver& entry, Time end_of_frame) noexcept {
  if (entry.owner == Owner::claim) claim_.sent(entry.frame, end_of_frame);
  if (entry.owner == Owner::session && sender_.job_at(entry.session) == entry.id)
    sender_.sent(entry.session, end_of_frame);
}

/// What follows from one of which nobody knows whether it did.
void Node::unseen(const HandedOver& entry) noexcept {
  if (entry.owner == Owner::claim) claim_.unseen(entry.frame);
  if (entry.owner == Owner::session && sender_.job_at(entry.session) == entry.id)
    sender_.unseen(entry.session, now_);
}

void Node::echo(const can::Frame& frame, Time end_of_frame) noexcept {
  ++counters_.sent;
  std::size_t found = 0;
  while (found < handed_over_.size() && handed_over_[found].frame != frame) ++found;
  if (found == handed_over_.size()) return;
  const HandedOver entry = handed_over_[found];
  handed_over_.erase(found);
  seen(entry, end_of_frame);
  if (entry.owner == Owner::order && !entry.answered) {
    const Order& order = entry.open.order;
    if (order.kind == OrderKind::request && order.destination != kGlobalAddress) {
      asked_.push(entry.open);  // there is room: no more requests are open
    } else {
      end(order, Outcome::done, {.sent = end_of_frame});
    }
  }
  overtake(found);
  take_ended();
}

/// The `count` frames handed over first: no echo of theirs is waited for; orders keep their places until
/// they are answered.
void Node::overtake(std::size_t count) noexcept {
  for (std::size_t i = count; i-- > 0;) {
    HandedOver& entry = handed_over_[i];
    entry.overtaken = true;
    if (entry.owner == Owner::order && !entry.answered) continue;
    unseen(entry);
    handed_over_.erase(i);
  }
}

void Node::echoes_lost() noexcept {
  overtake(handed_over_.size());
  take_ended();
}

void Node::controller_emptied() noexcept {
  for (; handed_over_.size() != 0; handed_over_.erase(0)) {
    const HandedOver& entry = handed_over_[0];
    if (entry.owner == Owner::order && !entry.answered) end(entry.open.order, Outcome::no_answer);
  }
  offer_.reset();
  sender_.drop();
  // Nothing is sent with the address until it is claimed anew: no message that waits begins before.
  receiver_.drop_connections();
  replies_.clear();
  claim_.start(now_);
  follow_address();
  take_ended();
}

/// Long messages for which there is room now.
void Node::begin_sessions() noexcept {
  const auto address = claim_.address();
  if (!address) return;
  for (std::size_t i = 0; i < waiting_.size() && !sending_.full();) {
    const Open open = waiting_[i];
    if (!is_long(open.order) || !sender_.has_room(open.order.destination)) {
      ++i;
      continue;
    }
    const std::uint64_t id = ++jobs_;
    sender_.begin(
        {id, open.order.number, open.order.priority, *address, open.order.destination, open.order.memory},
        now_);
    sending_.push({open, id, false});
    waiting_.erase(i);
  }
}

void Node::take_ended() noexcept {
  while (const auto ended = sender_.take_ended()) {
    for (std::size_t i = 0; i < sending_.size(); ++i) {
      if (sending_[i].id != ended->id) continue;
      const Sending sending = sending_[i];
      sending_.erase(i);
      if (sending.internal) break;
      const Outcome outcome = ended->end == SendEnd::done      ? Outcome::done
                              : ended->end == SendEnd::aborted ? Outcome::aborted
                                                               : Outcome::no_answer;
      end(sending.open.order, outcome, {.sent = ended->sent, .code = ended->reason});
      break;
    }
  }
  begin_sessions();
}

}  // namespace j1939
