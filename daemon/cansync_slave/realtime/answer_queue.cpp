#include "daemon/cansync_slave/realtime/answer_queue.h"

#include <algorithm>

namespace cansyncd {

void AnswerQueue::add(const Answer& answer) noexcept {
  if (size_ == kRoom) {
    ++counters_.failed;
    return;
  }
  answers_[size_++] = answer;
}

void AnswerQueue::drop(bool all) noexcept {
  for (unsigned place = size_; place > 0; --place) {
    if (all || answers_[place - 1].answer.slot != cansync::AnswerSlot::response) remove(place - 1);
  }
}

/// None overtakes another of its slot.
bool AnswerQueue::first_of_slot(unsigned place) const noexcept {
  for (unsigned before = 0; before < place; ++before) {
    if (answers_[before].answer.slot == answers_[place].answer.slot) return false;
  }
  return true;
}

can::Time AnswerQueue::next_deadline() const noexcept {
  can::Time earliest = can::Time::max();
  for (unsigned place = 0; place < size_; ++place) {
    if (first_of_slot(place)) earliest = std::min(earliest, begin(place));
  }
  return earliest;
}

std::optional<can::Frame> AnswerQueue::next(can::Time now, cansync::Slave& slave) noexcept {
  for (unsigned place = 0; place < size_;) {
    const Answer& answer = answers_[place];
    if (!first_of_slot(place) || begin(place) > now) {
      ++place;
    } else if (slave.may_start(answer.answer, now - answer.edge)) {
      handed_ = place;
      return answer.answer.frame;
    } else {
      remove(place);
    }
  }
  return std::nullopt;
}

void AnswerQueue::handed_over(can::SendResult result, can::Time now) noexcept {
  if (handed_ >= size_) return;
  const Answer& answer = answers_[handed_];
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
  remove(handed_);
  handed_ = 0;
}

void AnswerQueue::remove(unsigned place) noexcept {
  std::copy(answers_.begin() + place + 1, answers_.begin() + size_, answers_.begin() + place);
  --size_;
}

}  // namespace cansyncd
