#include "layer2/station.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "can/flagged_frames.h"

namespace layer2 {

static std::ostream& operator<<(std::ostream& out, Outcome outcome) {
  constexpr const char* kNames[] = {"done",    "no_answer", "timeout", "cancelled",
                                    "stopped", "displaced", "deleted"};
  return out << kNames[static_cast<int>(outcome)];
}

namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using std::chrono::milliseconds;

constexpr Time kTimeout = milliseconds(100);

SendOrder order(OrderId id, const can::Frame& frame, Time timeout = kTimeout) {
  return {id, frame, timeout};
}
SendOrder order(OrderId id) {
  return order(id, data_frame(static_cast<std::uint32_t>(0x100 + id), {static_cast<std::uint8_t>(id)}));
}

std::vector<Answer> answers(Station& station) {
  std::vector<Answer> all;
  while (const auto answer = station.take_answer()) all.push_back(*answer);
  return all;
}

/// The one answer there is.
Answer only_answer(Station& station) {
  const std::vector<Answer> all = answers(station);
  EXPECT_EQ(all.size(), 1u);
  return all.empty() ? Answer{} : all[0];
}

/// Hands the next frame over, and returns it.
can::Frame hand_over(Station& station) {
  const auto frame = station.next_frame();
  EXPECT_TRUE(frame);
  station.handed_over();
  return frame.value_or(can::Frame{});
}

TEST(Station, AFrameSeenOnTheBusIsDone) {
  for (const can::Frame& frame : can::test::four_kinds()) {
    Station station({});
    ASSERT_EQ(station.submit(order(7, frame), Time{0}), Refusal::none);
    EXPECT_EQ(hand_over(station), frame);
    EXPECT_FALSE(station.next_frame());
    EXPECT_FALSE(station.take_answer());
    station.echo(frame, milliseconds(3));
    const Answer answer = only_answer(station);
    EXPECT_EQ(answer.id, 7u);
    EXPECT_EQ(answer.outcome, Outcome::done);
    EXPECT_EQ(answer.sent, milliseconds(3));
    EXPECT_EQ(station.counters().sent, 1u);
  }
}

TEST(Station, WhatIsNotSentOfAFrameDoesNotKeepItFromItsEcho) {
  Station station({});
  can::Frame asked = data_frame(0x123, {1, 2});
  asked.data[5] = 9;  // beyond the length
  ASSERT_EQ(station.submit(order(1, asked), Time{0}), Refusal::none);
  EXPECT_EQ(hand_over(station), data_frame(0x123, {1, 2}));
  station.echo(data_frame(0x123, {1, 2}), Time{1});
  EXPECT_EQ(only_answer(station).outcome, Outcome::done);
}

TEST(Station, FramesLeaveInTheOrderOfTheirOrders) {
  Station station({});
  // Not by identifier: what waits is a queue.
  for (const OrderId id : {OrderId{3}, OrderId{1}, OrderId{2}}) {
    ASSERT_EQ(station.submit(order(id), Time{0}), Refusal::none);
  }
  EXPECT_EQ(hand_over(station).id, 0x103u);
  EXPECT_EQ(hand_over(station).id, 0x101u);
  EXPECT_EQ(hand_over(station).id, 0x102u);
}

TEST(Station, AFrameNotSeenInTimeHasNoAnswer) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), milliseconds(5)), Refusal::none);
  hand_over(station);
  EXPECT_EQ(station.next_deadline(), milliseconds(105));
  station.advance(milliseconds(105) - Time{1});
  EXPECT_FALSE(station.take_answer());
  station.advance(milliseconds(105));
  EXPECT_EQ(only_answer(station).outcome, Outcome::no_answer);
  EXPECT_EQ(station.next_deadline(), Time::max());
  EXPECT_EQ(station.counters().unanswered, 1u);
}

TEST(Station, AFrameThatTheBusDoesNotTakeTimesOutAndIsNotSent) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  ASSERT_EQ(station.submit(order(2), milliseconds(1)), Refusal::none);
  ASSERT_TRUE(station.next_frame());
  station.held_back(Obstacle::bus_off);
  ASSERT_TRUE(station.next_frame());  // asked again
  station.advance(kTimeout);
  const Answer answer = only_answer(station);
  EXPECT_EQ(answer.id, 1u);
  EXPECT_EQ(answer.outcome, Outcome::timeout);
  EXPECT_EQ(answer.obstacle, Obstacle::bus_off);
  EXPECT_EQ(hand_over(station).id, 0x102u);
  station.echo(order(2).frame, kTimeout);
  EXPECT_EQ(only_answer(station).outcome, Outcome::done);
  EXPECT_EQ(station.counters().not_sent, 1u);
}

TEST(Station, AnObstacleThatIsGoneIsNoCause) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  station.held_back(Obstacle::queue_full);
  hand_over(station);
  station.echo(order(1).frame, Time{1});
  ASSERT_EQ(only_answer(station).outcome, Outcome::done);
  ASSERT_EQ(station.submit(order(2), Time{1}), Refusal::none);
  station.advance(Time{1} + kTimeout);
  EXPECT_EQ(only_answer(station).obstacle, Obstacle::none);
}

// A frame that nobody acknowledges stands in the controller, and goes out when somebody does: its echo must
// not be taken for that of an equal frame that was ordered later.
TEST(Station, ALateEchoBelongsToTheFrameThatWasHandedOverFirst) {
  Station station({});
  const can::Frame frame = data_frame(0x200, {1});
  ASSERT_EQ(station.submit(order(1, frame), Time{0}), Refusal::none);
  hand_over(station);
  station.advance(kTimeout);
  ASSERT_EQ(only_answer(station).outcome, Outcome::no_answer);
  ASSERT_EQ(station.submit(order(2, frame), kTimeout), Refusal::none);
  hand_over(station);
  station.echo(frame, kTimeout + Time{1});
  EXPECT_FALSE(station.take_answer());
  station.echo(frame, kTimeout + Time{2});
  EXPECT_EQ(only_answer(station).id, 2u);
}

TEST(Station, ALaterFrameOnTheBusFreesThePlaceOfOneThatWasMissed) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  ASSERT_EQ(station.submit(order(2), Time{0}), Refusal::none);
  hand_over(station);
  station.advance(kTimeout / 2);
  hand_over(station);
  station.echo(order(2).frame, kTimeout / 2);
  EXPECT_EQ(only_answer(station).id, 2u);
  EXPECT_EQ(station.handed_over_count(), 1u);  // its time is not over
  station.advance(kTimeout);
  EXPECT_EQ(only_answer(station).outcome, Outcome::no_answer);
  EXPECT_EQ(station.handed_over_count(), 0u);
}

TEST(Station, NothingMoreIsHandedOverThanMayStandInTheController) {
  Station station({});
  for (OrderId id = 1; id <= 12; ++id) ASSERT_EQ(station.submit(order(id), Time{0}), Refusal::none);
  for (std::size_t i = 0; i < Station::kMostHandedOver; ++i) hand_over(station);
  EXPECT_FALSE(station.next_frame());
  station.advance(kTimeout);
  // The places are kept by what may stand in the controller still.
  ASSERT_EQ(station.submit(order(20), kTimeout), Refusal::none);
  EXPECT_FALSE(station.next_frame());
  const auto ended = answers(station);
  ASSERT_EQ(ended.size(), 12u);
  for (std::size_t i = 0; i < 12; ++i) {
    EXPECT_EQ(ended[i].outcome, i < Station::kMostHandedOver ? Outcome::no_answer : Outcome::timeout) << i;
  }
  station.controller_emptied();
  EXPECT_EQ(hand_over(station).id, order(20).frame.id);
  EXPECT_FALSE(station.take_answer());
}

TEST(Station, AResetOfTheControllerEndsWhatWasHandedOver) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  hand_over(station);
  station.controller_emptied();
  EXPECT_EQ(only_answer(station).outcome, Outcome::no_answer);
  EXPECT_EQ(station.handed_over_count(), 0u);
}

TEST(Station, LostEchoesKeepNoPlaceOfWhatWasAnswered) {
  Station station({});
  for (OrderId id = 1; id <= Station::kMostHandedOver; ++id) {
    const Time timeout = id == 1 ? kTimeout / 2 : kTimeout;
    ASSERT_EQ(station.submit(order(id, order(id).frame, timeout), Time{0}), Refusal::none);
    hand_over(station);
  }
  station.advance(kTimeout / 2);
  ASSERT_EQ(only_answer(station).id, 1u);
  station.echoes_lost();
  EXPECT_EQ(station.handed_over_count(), Station::kMostHandedOver - 1);  // the others' echoes may come yet
  station.echo(order(2).frame, kTimeout / 2);
  EXPECT_EQ(only_answer(station).outcome, Outcome::done);
  station.advance(kTimeout);
  EXPECT_EQ(answers(station).size(), Station::kMostHandedOver - 2);
  EXPECT_EQ(station.handed_over_count(), 0u);
  ASSERT_EQ(station.submit(order(20), kTimeout), Refusal::none);
  EXPECT_EQ(hand_over(station).id, order(20).frame.id);
}

TEST(Station, TheQueueIsBounded) {
  Station station({.queue = 3});
  for (OrderId id = 1; id <= 3; ++id) ASSERT_EQ(station.submit(order(id), Time{0}), Refusal::none);
  EXPECT_EQ(station.submit(order(4), Time{0}), Refusal::queue_full);
  hand_over(station);
  EXPECT_EQ(station.submit(order(4), Time{0}), Refusal::none);
  EXPECT_EQ(station.waiting(), 3u);
}

TEST(Station, L15TheOldestMakesPlaceAlsoWhileAsManyAreInTheControllerAsMayBe) {
  Station station({.queue = 2, .high_queue = 1, .overflow = Overflow::delete_oldest});
  OrderId id = 0;
  for (; id < Station::kMostHandedOver; ++id) {
    ASSERT_EQ(station.submit(order(id), Time{0}), Refusal::none);
    hand_over(station);
  }
  SendOrder urgent = order(++id);
  urgent.priority = Priority::high;
  ASSERT_EQ(station.submit(urgent, Time{0}), Refusal::none);
  const OrderId first = id + 1;
  for (OrderId more = first; more < first + 6; ++more)
    EXPECT_EQ(station.submit(order(more), Time{0}), Refusal::none) << more;
  const auto ended = answers(station);
  ASSERT_EQ(ended.size(), 4u);
  for (std::size_t i = 0; i < ended.size(); ++i) {
    EXPECT_EQ(ended[i].id, first + i);
    EXPECT_EQ(ended[i].outcome, Outcome::displaced);
  }
  EXPECT_TRUE(station.queue(Priority::normal).overflowed);
}

TEST(Station, NoAnswerIsLostWhenNobodyTakesThem) {
  Station station({.queue = Station::kMostQueue});
  std::size_t taken = 0;
  Time now{0};
  for (OrderId id = 1; id <= 3000; ++id) {
    if (station.submit(order(id, data_frame(0x100, {}), Time{1}), now) == Refusal::none) ++taken;
    now += Time{1};
    station.advance(now);
  }
  EXPECT_EQ(answers(station).size(), taken);
  EXPECT_LT(taken, 3000u);
  EXPECT_EQ(station.submit(order(1), now), Refusal::none);
}

TEST(Station, FramesThatCannotBeSentAreRefused) {
  Station station({});
  EXPECT_EQ(station.submit(order(1, data_frame(0x800, {})), Time{0}), Refusal::bad_frame);
  EXPECT_EQ(station.submit(order(1, extended(data_frame(0x20000000, {}))), Time{0}), Refusal::bad_frame);
  EXPECT_EQ(station.submit(order(1, can::test::error(data_frame(1, {}))), Time{0}), Refusal::bad_frame);
  can::Frame long_one = data_frame(1, {});
  long_one.dlc = 9;
  EXPECT_EQ(station.submit(order(1, long_one), Time{0}), Refusal::bad_frame);
  EXPECT_FALSE(station.take_answer());
  long_one.dlc = 8;
  EXPECT_EQ(station.submit(order(1, long_one), Time{0}), Refusal::none);
}

TEST(Station, AWaitingOrderCanBeCancelled) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  ASSERT_EQ(station.submit(order(2), Time{0}), Refusal::none);
  hand_over(station);
  EXPECT_FALSE(station.cancel(1));  // it is on its way
  EXPECT_TRUE(station.cancel(2));
  EXPECT_FALSE(station.cancel(2));
  const Answer answer = only_answer(station);
  EXPECT_EQ(answer.id, 2u);
  EXPECT_EQ(answer.outcome, Outcome::cancelled);
  EXPECT_FALSE(station.next_frame());
}

TEST(Station, StoppingAnswersEverything) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  ASSERT_EQ(station.submit(order(2), Time{0}), Refusal::none);
  hand_over(station);
  station.stop();
  const auto ended = answers(station);
  ASSERT_EQ(ended.size(), 2u);
  EXPECT_EQ(ended[0].outcome, Outcome::no_answer);
  EXPECT_EQ(ended[1].outcome, Outcome::stopped);
  EXPECT_EQ(station.submit(order(3), Time{0}), Refusal::stopped);
  EXPECT_FALSE(station.next_frame());
}

TEST(Station, AForeignEchoEndsNothing) {
  Station station({});
  ASSERT_EQ(station.submit(order(1), Time{0}), Refusal::none);
  hand_over(station);
  station.echo(remote(order(1).frame), Time{1});
  station.echo(extended(order(1).frame), Time{1});
  EXPECT_FALSE(station.take_answer());
  EXPECT_EQ(station.handed_over_count(), 1u);
}

TEST(Station, ReceivesThroughItsRanges) {
  StationSettings settings;
  ASSERT_TRUE(settings.filter.add({0x180, 0x1FF, false, FrameKinds::data}));
  ASSERT_TRUE(settings.filter.add({0x18FE0000, 0x18FEFFFF, true, FrameKinds::data_and_remote}));
  Station station(settings);
  EXPECT_EQ(station.receive(data_frame(0x181, {1})), 0);
  EXPECT_EQ(station.receive(extended(data_frame(0x18FEF100, {1}))), 1);
  EXPECT_FALSE(station.receive(remote(data_frame(0x181, {}))));
  EXPECT_FALSE(station.receive(data_frame(0x200, {})));
  EXPECT_EQ(station.counters().received, 4u);
  EXPECT_EQ(station.counters().taken, 2u);
}

}  // namespace
}  // namespace layer2
