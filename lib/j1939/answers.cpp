#include "j1939/answers.h"

namespace j1939 {

Outcome outcome_of(JobKnown known, JobEnd end) noexcept {
  switch (can::ending_of(known, end)) {
    case can::JobEnding::timeout:
      return Outcome::timeout;
    case can::JobEnding::cancelled:
      return Outcome::cancelled;
    case can::JobEnding::stopped:
      return Outcome::stopped;
    case can::JobEnding::lost:
      return Outcome::address_lost;
    case can::JobEnding::no_answer:
    case can::JobEnding::taken:
      break;
  }
  return Outcome::no_answer;
}

void Answers::begin(const Order& order) noexcept {
  if (order.kind == OrderKind::request) ++requests_;
}

void Answers::end(const Order& order, Outcome outcome, const Answer& rest) noexcept {
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

void Answers::end(const Order& order, JobKnown known, JobEnd end, Answer rest) noexcept {
  rest.ended_by = end;
  this->end(order, outcome_of(known, end), rest);
}

std::optional<Answer> Answers::take() noexcept {
  if (answers_.size() == 0) return std::nullopt;
  const Answer answer = answers_[0];
  answers_.erase(0);
  return answer;
}

}  // namespace j1939
