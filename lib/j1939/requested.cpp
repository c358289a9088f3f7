#include "j1939/requested.h"

#include <algorithm>

namespace j1939 {
namespace {

bool is_for(const Order& order, Pgn number, Address source) noexcept {
  return order.number == number && order.destination == source;
}

}  // namespace

bool Requested::waits_for(Pgn number, Address source) const noexcept {
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (is_for(asked_[i].open.order, number, source)) return true;
  }
  return false;
}

/// Ends what waits for this group from this node, each by `ends(order)`.
template <class Ends>
void Requested::end_where(Pgn number, Address source, Ends ends) noexcept {
  for (std::size_t i = 0; i < asked_.size();) {
    if (!is_for(asked_[i].open.order, number, source)) {
      ++i;
      continue;
    }
    ends(asked_[i].open.order);
    asked_.erase(i);
  }
}

void Requested::answered(const Message& message) noexcept {
  end_where(message.number, message.source, [&](const Order& order) {
    const std::size_t size = std::min(message.data.size(), order.memory.size());
    std::copy_n(message.data.begin(), size, order.memory.begin());
    answers_.end(order, Outcome::done, {.sent = message.end, .size = static_cast<std::uint32_t>(size)});
  });
}

void Requested::acknowledged(const Message& message, const Acknowledgement& said) noexcept {
  const auto outcome = said.kind == Acknowledgement::Kind::positive ? Outcome::done : Outcome::refused;
  end_where(said.number, message.source, [&](const Order& order) {
    answers_.end(order, outcome, {.sent = message.end, .code = static_cast<std::uint8_t>(said.kind)});
  });
}

bool Requested::cancel(OrderId id) noexcept {
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (asked_[i].open.order.id != id) continue;
    answers_.end(asked_[i].open.order, JobKnown::handed_over, JobEnd::cancelled);
    asked_.erase(i);
    return true;
  }
  return false;
}

void Requested::end_all(JobEnd end) noexcept {
  for (; asked_.size() != 0; asked_.erase(0)) answers_.end(asked_[0].open.order, JobKnown::handed_over, end);
}

void Requested::advance(Time now) noexcept {
  for (std::size_t i = 0; i < asked_.size();) {
    Asked& asked = asked_[i];
    const Order& order = asked.open.order;
    const bool over = asked.open.until <= now;
    if (over && asked.answer == 0) asked.answer = receiver_.coming(order.number, order.destination);
    if (!over || receiver_.is_coming(asked.answer)) {
      ++i;
      continue;
    }
    answers_.end(order, JobKnown::handed_over, JobEnd::time);
    asked_.erase(i);
  }
}

Time Requested::next_deadline() const noexcept {
  Time next = Time::max();
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    if (!receiver_.is_coming(asked_[i].answer)) next = std::min(next, asked_[i].open.until);
  }
  return next;
}

}  // namespace j1939
