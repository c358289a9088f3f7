#include "j1939/node.h"

#include <algorithm>
#include <utility>

namespace j1939 {
namespace {

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

}  // namespace

Node::Node(NodeSettings settings)
    : settings_(std::move(settings)),
      due_(settings_.provided.size(), Time::max()),
      queue_(std::clamp<std::size_t>(settings_.queue, 1, kMostQueue)),
      claim_(settings_.claim),
      receiver_(settings_.window, settings_.most_bytes, replies_),
      sender_(settings_.spacing, replies_) {}

void Node::start(Time now) noexcept {
  now_ = now;
  claim_.start(now);
  follow_address();
}

std::size_t Node::open() const noexcept {
  return waiting_.size() + handed_over_.size() + sending_.size() + asked_.size() + answers_.size();
}

bool Node::wants_claims_of_all(const Order& order) const noexcept {
  return order.kind == OrderKind::request && order.number == pgn::kAddressClaimed;
}

bool Node::has_room(const Order& order) const noexcept {
  // Each open order has room for its answer.
  if (open() >= kMostOpen) return false;
  if (order.kind == OrderKind::request) return requests_ < kMostRequests;
  std::size_t messages = 0;
  for (std::size_t i = 0; i < waiting_.size(); ++i) messages += waiting_[i].order.kind == OrderKind::send;
  return messages < queue_;
}

Refusal Node::submit(const Order& order, Time now) noexcept {
  now_ = std::max(now_, now);
  if (stopped_) return Refusal::stopped;
  if (order.kind == OrderKind::send && order.memory.size() > std::max(kMostBytes, settings_.most_bytes))
    return Refusal::too_long;
  if (!can_be_sent(order)) return Refusal::bad_order;
  if (is_extended(order) && order.destination == kGlobalAddress) return Refusal::too_long_for_all;
  if (!claim_.wanted() && !wants_claims_of_all(order)) return Refusal::no_address;
  if (!has_room(order)) return Refusal::queue_full;
  if (waiting_.size() == 0) obstacle_ = Obstacle::none;
  if (order.kind == OrderKind::request) ++requests_;
  waiting_.push({order, now + order.timeout});
  begin_sessions();
  return Refusal::none;
}

bool Node::cancel(OrderId id) noexcept {
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    if (waiting_[i].order.id != id) continue;
    end(waiting_[i].order, Outcome::cancelled);
    waiting_.erase(i);
    return true;
  }
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (asked_[i].order.id != id) continue;
    end(asked_[i].order, Outcome::cancelled);
    asked_.erase(i);
    return true;
  }
  for (std::size_t i = 0; i < sending_.size(); ++i) {
    if (sending_[i].internal || sending_[i].open.order.id != id) continue;
    if (!sender_.cancel(sending_[i].id)) continue;
    end(sending_[i].open.order, Outcome::cancelled);
    sending_.erase(i);
    return true;
  }
  return false;
}

/// With another address, or none, nothing that was begun with the old one can go on.
void Node::follow_address() noexcept {
  const auto wanted = claim_.wanted();
  if (wanted != own_) {
    if (own_) {
      receiver_.drop_connections();
      replies_.clear();
      offer_.reset();
      end_asked(Outcome::address_lost);
      for (; sending_.size() != 0; sending_.erase(0)) {
        (void)sender_.cancel(sending_[0].id);
        if (!sending_[0].internal) end(sending_[0].open.order, Outcome::address_lost);
      }
      replies_.clear();
      (void)sender_.take_ended();
    }
    own_ = wanted;
  }
  if (!wanted && claim_.state() == ClaimState::cannot_claim) end_waiting(Outcome::address_lost);
}

void Node::advance(Time now) noexcept {
  now_ = now;
  claim_.advance(now);
  follow_address();
  send_periodic();
  receiver_.advance(now);
  sender_.advance(now);
  for (std::size_t i = 0; i < sending_.size();) {
    if (sending_[i].open.until > now) {
      ++i;
      continue;
    }
    const bool begun = sender_.begun(sending_[i].id);
    (void)sender_.cancel(sending_[i].id);
    if (!sending_[i].internal) {
      end(sending_[i].open.order, begun ? Outcome::no_answer : Outcome::timeout,
          {.obstacle = begun ? Obstacle::none : obstacle_});
    }
    sending_.erase(i);
  }
  for (std::size_t i = 0; i < handed_over_.size();) {
    HandedOver& entry = handed_over_[i];
    if (entry.owner == Owner::order && !entry.answered && entry.open.until <= now) {
      end(entry.open.order, Outcome::no_answer);
      entry.answered = true;
    }
    if (entry.owner == Owner::order && entry.answered && entry.overtaken) {
      handed_over_.erase(i);
    } else {
      ++i;
    }
  }
  end_unanswered();
  for (std::size_t i = 0; i < waiting_.size();) {
    if (waiting_[i].until > now) {
      ++i;
      continue;
    }
    const bool claiming = claim_.state() == ClaimState::claiming && obstacle_ == Obstacle::none;
    end(waiting_[i].order, Outcome::timeout, {.obstacle = obstacle_, .claiming = claiming});
    waiting_.erase(i);
  }
  take_ended();
}

/// The requests whose time is over. An answer that is coming in packets then is waited for, and no other:
/// whoever begins again and again would hold its place.
void Node::end_unanswered() noexcept {
  for (std::size_t i = 0; i < asked_.size();) {
    Open& asked = asked_[i];
    const bool over = asked.until <= now_;
    if (over && asked.answer == 0)
      asked.answer = receiver_.coming(asked.order.number, asked.order.destination);
    if (!over || receiver_.is_coming(asked.answer)) {
      ++i;
      continue;
    }
    end(asked.order, Outcome::no_answer);
    asked_.erase(i);
  }
}

Time Node::next_deadline() const noexcept {
  Time next =
      std::min({claim_.next_deadline(), receiver_.next_deadline(), sender_.next_deadline(), next_periodic()});
  for (std::size_t i = 0; i < waiting_.size(); ++i) next = std::min(next, waiting_[i].until);
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (!receiver_.is_coming(asked_[i].answer)) next = std::min(next, asked_[i].until);
  }
  for (std::size_t i = 0; i < sending_.size(); ++i) next = std::min(next, sending_[i].open.until);
  for (std::size_t i = 0; i < handed_over_.size(); ++i) {
    const HandedOver& entry = handed_over_[i];
    if (entry.owner == Owner::order && !entry.answered) next = std::min(next, entry.open.until);
  }
  return next;
}

std::optional<Answer> Node::take_answer() noexcept {
  if (answers_.size() == 0) return std::nullopt;
  const Answer answer = answers_[0];
  answers_.erase(0);
  return answer;
}

void Node::stop() noexcept {
  stopped_ = true;
  for (; handed_over_.size() != 0; handed_over_.erase(0)) {
    const HandedOver& entry = handed_over_[0];
    if (entry.owner == Owner::order && !entry.answered) end(entry.open.order, Outcome::no_answer);
  }
  for (; sending_.size() != 0; sending_.erase(0)) {
    (void)sender_.cancel(sending_[0].id);
    if (!sending_[0].internal) end(sending_[0].open.order, Outcome::stopped);
  }
  end_asked(Outcome::stopped);
  end_waiting(Outcome::stopped);
}

void Node::end_waiting(Outcome outcome) noexcept {
  for (std::size_t i = 0; i < waiting_.size();) {
    if (outcome == Outcome::address_lost && wants_claims_of_all(waiting_[i].order)) {
      ++i;
      continue;
    }
    end(waiting_[i].order, outcome);
    waiting_.erase(i);
  }
}

void Node::end_asked(Outcome outcome) noexcept {
  for (; asked_.size() != 0; asked_.erase(0)) end(asked_[0].order, outcome);
}

void Node::end(const Order& order, Outcome outcome, const Answer& rest) noexcept {
  if (order.kind == OrderKind::request) --requests_;
  Answer answer = rest;
  answer.id = order.id;
  answer.outcome = outcome;
  answers_.push(answer);
  switch (outcome) {
    case Outcome::done:
      break;
    case Outcome::refused:
    case Outcome::aborted:
    case Outcome::no_answer:
      ++counters_.unanswered;
      break;
    default:
      ++counters_.not_sent;
  }
}

}  // namespace j1939
