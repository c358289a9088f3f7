#include "daemon/cansync_slave/realtime/answer_queue.h"

#include <algorithm>

namespace cansyncd {

void AnswerQueue::add(const Answer& answer) noexcept {
  if (size_ == kRoom) {
    ++counters_.failed;
    return;
  }
  answers_[(first_ + size_) % kRoom] = answer;
  ++size_;
}

can::Time AnswerQueue::next_deadline() const noexcept {
  if (size_ == 0) return can::Time::max();
  return answers_[first_].edge + answers_[first_].answer.window.earliest;
}

std::optional<can::Frame> AnswerQueue::next(can::Time now, cansync::Slave& slave) noexcept {
  while (due(now)) {
    const Answer& answer = answers_[first_];
    if (slave.may_start(answer.answer, now - answer.edge)) return answer.answer.frame;
    pop();
  }
  return std::nullopt;
}

void AnswerQueue::handed_over(can::SendResult result, can::Time now) noexcept {
  if (size_ == 0) return;
  const Answer& answer = answers_[first_];
  if (result != can::SendResult::queued) {
    ++counters_.failed;  // never again: the next turn would be another one's slot
  } else {
    const can::Time begin = std::max(answer.asked, answer.edge + answer.answer.window.earliest);
    counters_.response_last = now - begin;
    counters_.response_longest = std::max(counters_.response_longest, counters_.response_last);
    if (answer.answer.slot != cansync::AnswerSlot::response) {
      const can::Time margin = answer.edge + answer.answer.window.latest - now;
      const bool first = counters_.margin_least == can::Time{0};
      counters_.margin_least = first ? margin : std::min(counters_.margin_least, margin);
    }
  }
  pop();
}

void AnswerQueue::pop() noexcept {
  first_ = (first_ + 1) % kRoom;
  --size_;
}

}  // namespace cansyncd
