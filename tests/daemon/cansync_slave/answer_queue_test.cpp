#include "daemon/cansync_slave/realtime/answer_queue.h"

#include <gtest/gtest.h>

#include <chrono>

#include "silent_application.h"

namespace cansyncd {
namespace {

using cansync::AnswerSlot;
using std::chrono::microseconds;

class AnswerQueueTest : public testing::Test {
 protected:
  static can::Time at(int time) { return microseconds(time); }
  /// Its frame has `id`.
  void add(std::uint32_t id, AnswerSlot slot, int earliest, int latest) {
    cansync::SlaveAnswer answer;
    answer.frame.id = id;
    answer.slot = slot;
    answer.window = {at(earliest), at(latest)};
    queue_.add({answer, {}, at(earliest)});
  }
  /// Identifier of what is handed over then; 0: nothing.
  std::uint32_t next(int time) {
    const auto frame = queue_.next(at(time), slave_);
    if (!frame) return 0;
    queue_.handed_over(can::SendResult::queued, at(time));
    return frame->identifier();
  }

  test::SilentApplication nobody_;
  cansync::Slave slave_{{}, nobody_};
  AnswerQueue queue_;
};

TEST_F(AnswerQueueTest, AResponseOfTheNextIntervalDoesNotBlockActualValuesOfThisOne) {
  add(0x585, AnswerSlot::response, 1000, 1210);
  add(0x305, AnswerSlot::actual_one, 400, 520);
  EXPECT_EQ(queue_.next_deadline(), at(400));
  EXPECT_EQ(next(399), 0u);
  EXPECT_EQ(next(410), 0x305u);
  EXPECT_EQ(queue_.next_deadline(), at(1000));
  add(0x385, AnswerSlot::actual_two, 700, 820);
  EXPECT_EQ(next(710), 0x385u);
  EXPECT_EQ(next(1000), 0x585u);
  EXPECT_EQ(queue_.next_deadline(), can::Time::max());
}

TEST_F(AnswerQueueTest, WhatIsTooLateIsLeftOutAndTheRestGoesOut) {
  add(0x585, AnswerSlot::response, 1000, 1210);
  add(0x305, AnswerSlot::actual_one, 400, 520);
  add(0x385, AnswerSlot::actual_two, 700, 820);
  EXPECT_EQ(next(750), 0x385u);
  EXPECT_EQ(slave_.counters(cansync::Channel::one).late, 1u);
  EXPECT_EQ(next(1100), 0x585u);
}

TEST_F(AnswerQueueTest, NoResponseOvertakesAnother) {
  add(0x585, AnswerSlot::response, 1000, 1210);
  add(0x586, AnswerSlot::response, 960, 1210);
  EXPECT_EQ(next(970), 0u);
  EXPECT_EQ(next(1000), 0x585u);
  EXPECT_EQ(next(1000), 0x586u);
}

TEST_F(AnswerQueueTest, WhatWaitsIsDroppedWithTheStateThatItCameFrom) {
  add(0x585, AnswerSlot::response, 1000, 1210);
  add(0x305, AnswerSlot::actual_one, 400, 520);
  add(0x385, AnswerSlot::actual_two, 700, 820);
  queue_.drop(false);
  EXPECT_EQ(queue_.next_deadline(), at(1000)) << "parameters are answered without active operation, too";
  queue_.drop(true);
  EXPECT_EQ(queue_.next_deadline(), can::Time::max());
  add(0x585, AnswerSlot::response, 1000, 1210);
  EXPECT_EQ(next(1000), 0x585u);
}

}  // namespace
}  // namespace cansyncd
