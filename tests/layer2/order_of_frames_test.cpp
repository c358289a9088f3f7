// Orders of several frames: one place in the queue, one answer.
#include <gtest/gtest.h>

#include <array>
#include <chrono>

#include "can/flagged_frames.h"
#include "layer2/station.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using std::chrono::milliseconds;

constexpr Time kTimeout = milliseconds(100);
constexpr std::size_t kMany = 12;  // more than fit into the controller

class OrderOfFrames : public testing::Test {
 protected:
  OrderOfFrames() {
    for (std::size_t i = 0; i < kMany; ++i) frames_[i] = data_frame(0x200, {static_cast<std::uint8_t>(i)});
  }
  SendOrder order(OrderId id, std::size_t count = kMany) const {
    return {.id = id,
            .frame = frames_[0],
            .timeout = kTimeout,
            .following = std::span(frames_).subspan(1, count - 1)};
  }
  can::Frame hand_over() {
    const auto frame = station_.next_frame();
    EXPECT_TRUE(frame);
    station_.handed_over();
    return frame.value_or(can::Frame{});
  }
  void expect_answer(OrderId id, Outcome outcome, unsigned seen) {
    const auto answer = station_.take_answer();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->id, id);
    EXPECT_EQ(answer->outcome, outcome);
    EXPECT_EQ(answer->seen, seen);
    EXPECT_FALSE(station_.take_answer());
  }

  std::array<can::Frame, kMany> frames_ = {};
  Station station_{{.queue = 2}};
};

TEST_F(OrderOfFrames, AllAreSentInOrderFromOnePlaceAndAnsweredOnce) {
  ASSERT_EQ(station_.submit(order(1), Time{0}), Refusal::none);
  EXPECT_EQ(station_.waiting(), 1u);
  for (std::size_t i = 0; i < kMany; ++i) {
    EXPECT_EQ(hand_over(), frames_[i]);
    EXPECT_FALSE(station_.take_answer());
    station_.echo(frames_[i], milliseconds(i + 1));
  }
  EXPECT_EQ(station_.waiting(), 0u);
  const auto answer = station_.take_answer();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->outcome, Outcome::done);
  EXPECT_EQ(answer->seen, kMany);
  EXPECT_EQ(answer->sent, milliseconds(kMany));
  EXPECT_EQ(station_.counters().sent, kMany);
  EXPECT_FALSE(station_.next_frame());
}

TEST_F(OrderOfFrames, WhatIsOfHighPriorityGoesBetweenItsFrames) {
  ASSERT_EQ(station_.submit(order(1, 2), Time{0}), Refusal::none);
  EXPECT_EQ(hand_over(), frames_[0]);
  const can::Frame high = data_frame(0x7FF, {});
  ASSERT_EQ(station_.submit({2, high, kTimeout, Priority::high}, Time{0}), Refusal::none);
  EXPECT_EQ(hand_over(), high);
  EXPECT_EQ(hand_over(), frames_[1]);
}

TEST_F(OrderOfFrames, NoMoreThanFitAreInTheController) {
  ASSERT_EQ(station_.submit(order(1), Time{0}), Refusal::none);
  for (std::size_t i = 0; i < Station::kMostHandedOver; ++i) (void)hand_over();
  EXPECT_FALSE(station_.next_frame());
  station_.echo(frames_[0], Time{1});
  EXPECT_EQ(hand_over(), frames_[Station::kMostHandedOver]);
}

TEST_F(OrderOfFrames, TakenBackItSaysHowManyWereSent) {
  ASSERT_EQ(station_.submit(order(1), Time{0}), Refusal::none);
  for (int i = 0; i < 3; ++i) (void)hand_over();
  station_.echo(frames_[0], Time{1});
  EXPECT_TRUE(station_.cancel(1));
  EXPECT_FALSE(station_.next_frame());
  EXPECT_FALSE(station_.take_answer()) << "two are in the controller";
  station_.echo(frames_[1], Time{2});
  station_.echo(frames_[2], Time{3});
  expect_answer(1, Outcome::cancelled, 3);
  ASSERT_EQ(station_.submit(order(2), Time{0}), Refusal::none);
  EXPECT_TRUE(station_.cancel(2));
  expect_answer(2, Outcome::cancelled, 0);
}

TEST_F(OrderOfFrames, ItsTimeCountsForAll) {
  ASSERT_EQ(station_.submit(order(1), Time{0}), Refusal::none);
  (void)hand_over();
  station_.echo(frames_[0], Time{1});
  station_.advance(kTimeout);
  expect_answer(1, Outcome::timeout, 1);
  ASSERT_EQ(station_.submit(order(2), kTimeout), Refusal::none);
  (void)hand_over();
  EXPECT_EQ(station_.next_deadline(), 2 * kTimeout);
  station_.advance(2 * kTimeout);
  expect_answer(2, Outcome::no_answer, 0);
  EXPECT_FALSE(station_.next_frame());
  station_.echo(frames_[0], 3 * kTimeout);  // late
  EXPECT_FALSE(station_.take_answer());
}

TEST_F(OrderOfFrames, NothingIsSentBehindAFrameThatWasLost) {
  ASSERT_EQ(station_.submit(order(1), Time{0}), Refusal::none);
  for (int i = 0; i < 2; ++i) (void)hand_over();
  station_.echo(frames_[0], Time{1});
  station_.controller_emptied();
  expect_answer(1, Outcome::no_answer, 1);
  EXPECT_FALSE(station_.next_frame());
}

TEST_F(OrderOfFrames, AnEchoThatWasMissedIsNotDone) {
  ASSERT_EQ(station_.submit(order(1, 3), Time{0}), Refusal::none);
  for (int i = 0; i < 3; ++i) (void)hand_over();
  station_.echo(frames_[1], Time{1});
  station_.echo(frames_[2], Time{2});
  expect_answer(1, Outcome::no_answer, 2);
}

TEST_F(OrderOfFrames, DisplacedDeletedOrStoppedItIsAnsweredOnce) {
  Station deletes({.queue = 1, .overflow = Overflow::delete_oldest});
  ASSERT_EQ(deletes.submit(order(1), Time{0}), Refusal::none);
  deletes.next_frame();
  deletes.handed_over();
  ASSERT_EQ(deletes.submit(order(2), Time{0}), Refusal::none);
  EXPECT_FALSE(deletes.take_answer());
  deletes.echo(frames_[0], Time{1});
  EXPECT_EQ(deletes.take_answer()->outcome, Outcome::displaced);
  deletes.clear_queues();
  EXPECT_EQ(deletes.take_answer()->outcome, Outcome::deleted);
  ASSERT_EQ(deletes.submit(order(3), Time{0}), Refusal::none);
  deletes.next_frame();
  deletes.handed_over();
  deletes.stop();
  EXPECT_EQ(deletes.take_answer()->outcome, Outcome::no_answer);
  EXPECT_FALSE(deletes.take_answer());
}

TEST_F(OrderOfFrames, AWrongFrameRefusesAll) {
  frames_[kMany - 1].id = 0x800;
  EXPECT_EQ(station_.submit(order(1), Time{0}), Refusal::bad_frame);
  EXPECT_EQ(station_.waiting(), 0u);
}

}  // namespace
}  // namespace layer2
