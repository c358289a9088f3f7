#include "j1939/answers.h"

namespace j1939 {

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

std::optional<Answer> Answers::take() noexcept {
  if (answers_.size() == 0) return std::nullopt;
  const Answer answer = answers_[0];
  answers_.erase(0);
  return answer;
}

}  // namespace j1939
