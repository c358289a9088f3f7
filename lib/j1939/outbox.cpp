#include "j1939/outbox.h"

#include "j1939/codec.h"
#include "j1939/message.h"

namespace j1939 {
namespace {

/// For the node's own long answers: the receiver may hold it, but not for ever.
constexpr Time kLongestAnswer = std::chrono::seconds(60);

/// By the extended transport protocol, which knows no broadcast.
bool is_extended(const Order& order) noexcept {
  return order.kind == OrderKind::send && order.memory.size() > kMostBytes;
}

bool can_be_sent(const Order& order) noexcept {
  if (!is_pgn(order.number) || order.priority > 7 || order.destination == kNullAddress) return false;
  if (order.kind == OrderKind::request) return true;
  if (is_reserved(order.number)) return false;
  return has_destination(order.number) || order.destination == kGlobalAddress || is_long(order);
}

/// A node without an address may ask for those of the others.
bool wants_claims_of_all(const Order& order) noexcept {
  return order.kind == OrderKind::request && order.number == pgn::kAddressClaimed;
}

can::Frame frame_for(const Order& order, Address source) noexcept {
  if (order.kind == OrderKind::request)
    return request_frame(order.number, source, order.destination, order.priority);
  can::Frame frame;
  frame.extended = true;
  frame.id = compose(identifier_of(order.number, order.priority, order.destination, source));
  frame.dlc = static_cast<std::uint8_t>(order.memory.size());
  std::copy(order.memory.begin(), order.memory.end(), frame.data.begin());
  return frame;
}

}  // namespace

Outbox::Outbox(const OutboxSettings& settings, AddressClaim& claim, FrameQueue& replies,
               const TransportReceiver& receiver, NodeCounters& counters) noexcept
    : settings_(settings),
      claim_(claim),
      replies_(replies),
      counters_(counters),
      sender_(settings.spacing, replies),
      answers_(counters),
      requested_(answers_, receiver) {
  settings_.messages = std::clamp<std::size_t>(settings_.messages, 1, kMostMessages);
}

std::size_t Outbox::open() const noexcept {
  return waiting_.size() + handed_over_.size() + sending_.size() + requested_.size() + answers_.size();
}

bool Outbox::has_room(const Order& order) const noexcept {
  // Each open order has room for its answer.
  if (open() >= kMostOpen) return false;
  if (order.kind == OrderKind::request) return answers_.requests() < kMostRequests;
  std::size_t messages = 0;
  for (std::size_t i = 0; i < waiting_.size(); ++i) messages += waiting_[i].order.kind == OrderKind::send;
  return messages < settings_.messages;
}

Refusal Outbox::submit(const Order& order, Time now) noexcept {
  time_is(now);
  if (stopped_) return Refusal::stopped;
  if (order.kind == OrderKind::send && order.memory.size() > std::max(kMostBytes, settings_.most_bytes))
    return Refusal::too_long;
  if (!can_be_sent(order)) return Refusal::bad_order;
  if (is_extended(order) && order.destination == kGlobalAddress) return Refusal::too_long_for_all;
  if (!claim_.wanted() && claim_.state() != ClaimState::asking && !wants_claims_of_all(order))
    return Refusal::no_address;
  if (!has_room(order)) return Refusal::queue_full;
  if (waiting_.size() == 0) obstacle_ = Obstacle::none;
  answers_.begin(order);
  waiting_.push({order, now + order.timeout});
  begin_sessions();
  return Refusal::none;
}

bool Outbox::cancel(OrderId id) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (waiting_[i].order.id != id) continue;
    answers_.end(waiting_[i].order, JobKnown::not_sent, JobEnd::cancelled);
    waiting_.erase(i);
    return true;
  }
  if (requested_.cancel(id)) return true;
  for (std::size_t i = 0; i < sending_.size(); ++i) {
    if (sending_[i].internal || sending_[i].open.order.id != id) continue;
    const JobKnown known = known_of(sending_[i]);
    if (!sender_.cancel(sending_[i].id)) continue;
    answers_.end(sending_[i].open.order, known, JobEnd::cancelled);
    sending_.erase(i);
    return true;
  }
  return false;
}

std::optional<can::Frame> Outbox::next_frame() noexcept {
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

void Outbox::handed_over() noexcept {
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
void Outbox::seen(const HandedOver& entry, Time end_of_frame) noexcept {
  if (entry.owner == Owner::claim) claim_.sent(entry.frame, end_of_frame);
  if (entry.owner == Owner::session && sender_.job_at(entry.session) == entry.id)
    sender_.sent(entry.session, end_of_frame);
}

/// What follows from one of which nobody knows whether it did.
void Outbox::unseen(const HandedOver& entry) noexcept {
  if (entry.owner == Owner::claim) claim_.unseen(entry.frame);
  if (entry.owner == Owner::session && sender_.job_at(entry.session) == entry.id)
    sender_.unseen(entry.session, now_);
}

void Outbox::echo(const can::Frame& frame, Time end_of_frame) noexcept {
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
      requested_.add(entry.open);
    } else {
      answers_.end(order, Outcome::done, {.sent = end_of_frame});
    }
  }
  overtake(found);
  follow_packets();
}

/// The `count` frames handed over first: no echo of theirs is waited for; orders keep their places until
/// they are answered.
void Outbox::overtake(std::size_t count) noexcept {
  for (std::size_t i = count; i-- > 0;) {
    HandedOver& entry = handed_over_[i];
    entry.overtaken = true;
    if (entry.owner == Owner::order && !entry.answered) continue;
    unseen(entry);
    handed_over_.erase(i);
  }
}

void Outbox::echoes_lost() noexcept {
  overtake(handed_over_.size());
  follow_packets();
}

Outbox::OwnMessage Outbox::send_own(Pgn number, std::uint8_t priority, Address to,
                                    std::span<const std::uint8_t> data) noexcept {
  for (std::size_t i = 0; i < own_waiting_.size(); ++i) {
    if (own_waiting_[i].number == number && own_waiting_[i].to == to) return OwnMessage::waiting;
  }
  if (own_waiting_.full()) return OwnMessage::full;
  own_waiting_.push({number, priority, to, data});
  begin_sessions();
  return OwnMessage::taken;
}

/// The first own message for which there is room; behind the last one: none.
std::size_t Outbox::next_own() const noexcept {
  std::size_t i = 0;
  while (i < own_waiting_.size() && !sender_.has_room(own_waiting_[i].to)) ++i;
  return i;
}

/// The first order of several packets for which there is room; behind the last one: none.
std::size_t Outbox::next_order() const noexcept {
  std::size_t i = 0;
  while (i < waiting_.size() &&
         !(is_long(waiting_[i].order) && sender_.has_room(waiting_[i].order.destination)))
    ++i;
  return i;
}

/// Long messages for which there is room now; own ones and orders take turns.
void Outbox::begin_sessions() noexcept {
  const auto address = claim_.address();
  if (!address) return;
  while (!sending_.full()) {
    const std::size_t own = next_own();
    const std::size_t order = next_order();
    const bool has_own = own < own_waiting_.size();
    const bool has_order = order < waiting_.size();
    if (!has_own && !has_order) return;
    const std::uint64_t id = ++jobs_;
    if (has_order && (orders_turn_ || !has_own)) {
      const OpenOrder open = waiting_[order];
      sender_.begin(
          {id, open.order.number, open.order.priority, *address, open.order.destination, open.order.memory},
          now_);
      sending_.push({open, id, false});
      waiting_.erase(order);
      orders_turn_ = false;
    } else {
      const Own message = own_waiting_[own];
      sender_.begin({id, message.number, message.priority, *address, message.to, message.data}, now_);
      sending_.push({{{}, now_ + kLongestAnswer}, id, true});
      own_waiting_.erase(own);
      orders_turn_ = true;
    }
  }
}

void Outbox::follow_packets() noexcept {
  while (const auto ended = sender_.take_ended()) {
    for (std::size_t i = 0; i < sending_.size(); ++i) {
      if (sending_[i].id != ended->id) continue;
      const Sending sending = sending_[i];
      sending_.erase(i);
      if (sending.internal) break;
      const Outcome outcome = ended->end == SendEnd::done      ? Outcome::done
                              : ended->end == SendEnd::aborted ? Outcome::aborted
                                                               : Outcome::no_answer;
      answers_.end(sending.open.order, outcome, {.sent = ended->sent, .code = ended->reason});
      break;
    }
  }
  begin_sessions();
}

void Outbox::controller_emptied() noexcept {
  end_handed_over(JobEnd::unanswered);
  offer_.reset();
  own_waiting_ = {};
  take_back_unbegun();
  sender_.drop();
  follow_packets();
}

void Outbox::address_changed() noexcept {
  offer_.reset();
  own_waiting_ = {};
  take_back_unbegun();
  requested_.end_all(JobEnd::lost);
  end_sending(JobEnd::lost);
  (void)sender_.take_ended();
}

/// Orders in packets of which nothing was handed over wait on, as those of one frame do.
void Outbox::take_back_unbegun() noexcept {
  for (std::size_t i = 0; i < sending_.size();) {
    const Sending& sending = sending_[i];
    if (sending.internal || waiting_.full() || sender_.begun(sending.id) || !sender_.cancel(sending.id)) {
      ++i;
      continue;
    }
    waiting_.push(sending.open);
    sending_.erase(i);
  }
}

void Outbox::advance(Time now) noexcept {
  now_ = now;
  sender_.advance(now);
  advance_sending();
  advance_handed_over();
  requested_.advance(now);
  advance_waiting();
  follow_packets();
}

void Outbox::advance_sending() noexcept {
  for (std::size_t i = 0; i < sending_.size();) {
    if (sending_[i].open.until > now_) {
      ++i;
      continue;
    }
    const JobKnown known = known_of(sending_[i]);
    (void)sender_.cancel(sending_[i].id);
    if (!sending_[i].internal) {
      answers_.end(sending_[i].open.order, known, JobEnd::time,
                   {.obstacle = known == JobKnown::not_sent ? obstacle_ : Obstacle::none});
    }
    sending_.erase(i);
  }
}

void Outbox::advance_handed_over() noexcept {
  for (std::size_t i = 0; i < handed_over_.size();) {
    HandedOver& entry = handed_over_[i];
    if (entry.owner == Owner::order && !entry.answered && entry.open.until <= now_) {
      answers_.end(entry.open.order, JobKnown::handed_over, JobEnd::time);
      entry.answered = true;
    }
    if (entry.owner == Owner::order && entry.answered && entry.overtaken) {
      handed_over_.erase(i);
    } else {
      ++i;
    }
  }
}

void Outbox::advance_waiting() noexcept {
  for (std::size_t i = 0; i < waiting_.size();) {
    if (waiting_[i].until > now_) {
      ++i;
      continue;
    }
    const bool on_the_way = claim_.state() == ClaimState::asking || claim_.state() == ClaimState::claiming;
    const bool claiming = on_the_way && obstacle_ == Obstacle::none;
    answers_.end(waiting_[i].order, JobKnown::not_sent, JobEnd::time,
                 {.obstacle = obstacle_, .claiming = claiming});
    waiting_.erase(i);
  }
}

Time Outbox::next_deadline() const noexcept {
  Time next = std::min(sender_.next_deadline(), requested_.next_deadline());
  for (std::size_t i = 0; i < waiting_.size(); ++i) next = std::min(next, waiting_[i].until);
  for (std::size_t i = 0; i < sending_.size(); ++i) next = std::min(next, sending_[i].open.until);
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    const HandedOver& entry = handed_over_[i];
    if (entry.owner == Owner::order && !entry.answered) next = std::min(next, entry.open.until);
  }
  return next;
}

void Outbox::stop() noexcept {
  stopped_ = true;
  own_waiting_ = {};
  end_handed_over(JobEnd::stopped);
  end_sending(JobEnd::stopped);
  requested_.end_all(JobEnd::stopped);
  end_waiting(JobEnd::stopped);
}

void Outbox::end_handed_over(JobEnd end) noexcept {
  for (; handed_over_.size() != 0; handed_over_.erase(0)) {
    const HandedOver& entry = handed_over_[0];
    if (entry.owner == Owner::order && !entry.answered)
      answers_.end(entry.open.order, JobKnown::handed_over, end);
  }
}

void Outbox::end_sending(JobEnd end) noexcept {
  for (; sending_.size() != 0; sending_.erase(0)) {
    const JobKnown known = known_of(sending_[0]);
    (void)sender_.cancel(sending_[0].id);
    if (!sending_[0].internal) answers_.end(sending_[0].open.order, known, end);
  }
}

void Outbox::end_waiting(JobEnd end) noexcept {
  for (std::size_t i = 0; i < waiting_.size();) {
    if (end == JobEnd::lost && wants_claims_of_all(waiting_[i].order)) {
      ++i;
      continue;
    }
    answers_.end(waiting_[i].order, JobKnown::not_sent, end);
    waiting_.erase(i);
  }
}

JobKnown Outbox::known_of(const Sending& sending) const noexcept {
  return sender_.begun(sending.id) ? JobKnown::handed_over : JobKnown::not_sent;
}

}  // namespace j1939
