// Orders to send: their turn, their room, and how they end.
#include "j1939/outbox.h"

#include "j1939/node_fixture.h"

namespace j1939::test {
namespace {

TEST_F(NodeTest, AnOrderIsDoneWhenItsFrameStoodOnTheBus) {
  ASSERT_EQ(rig.node.submit(message(5, 0xFEF1, 8), rig.now), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x0CFEF180, {1, 2, 3, 4, 5, 6, 7, 8})});
  const Answer answer = only_answer();
  EXPECT_EQ(answer.id, 5u);
  EXPECT_EQ(answer.outcome, Outcome::done);
  EXPECT_EQ(answer.sent, rig.now);
}

TEST_F(NodeTest, TheMostUrgentGoesFirstAndEqualOnesInTheirOrder) {
  std::vector<std::uint8_t> one = {1};
  std::vector<std::uint8_t> two = {2};
  const auto give = [&](OrderId id, std::uint8_t priority, std::vector<std::uint8_t>& bytes) {
    return rig.node.submit(
        {.id = id, .number = 0xFEF1, .priority = priority, .timeout = milliseconds(100), .memory = bytes},
        rig.now);
  };
  ASSERT_EQ(give(1, 6, one), Refusal::none);
  ASSERT_EQ(give(2, 3, one), Refusal::none);
  ASSERT_EQ(give(3, 6, two), Refusal::none);
  EXPECT_EQ(rig.pump(),
            (std::vector{frame(0x0CFEF180, {1}), frame(0x18FEF180, {1}), frame(0x18FEF180, {2})}));
}

TEST_F(NodeTest, OrdersWaitForTheAddressAndEndWhenItIsNotClaimedInTime) {
  NodeRig fresh;
  ASSERT_EQ(fresh.node.submit(message(1, 0xFEF1, 1), fresh.now), Refusal::none);
  EXPECT_EQ(fresh.pump().size(), 2u) << "the claim alone";
  (void)fresh.run(milliseconds(100));
  const auto all = fresh.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::timeout);
  EXPECT_TRUE(all[0].claiming);
  Order patient = message(2, 0xFEF1, 1);
  patient.timeout = milliseconds(500);
  ASSERT_EQ(fresh.node.submit(patient, fresh.now), Refusal::none);
  EXPECT_EQ(fresh.run(milliseconds(250)), std::vector{frame(0x0CFEF180, {1})});
}

TEST(AskingNode, OrdersWaitWhileItAsksWhichAddressesAreFree) {
  NodeSettings settings = settings_at(kOwn);
  settings.claim.ask_time = milliseconds(250);
  NodeRig fresh(settings);
  ASSERT_EQ(fresh.node.claim().state(), ClaimState::asking);
  std::vector<std::uint8_t> data = {1};
  EXPECT_EQ(fresh.node.submit({.id = 1, .number = 0xFEF1, .timeout = std::chrono::seconds(9), .memory = data},
                              fresh.now),
            Refusal::none);
  (void)fresh.run(milliseconds(499));
  EXPECT_TRUE(fresh.answers().empty());
  EXPECT_EQ(fresh.run(milliseconds(2)).size(), 1u) << "claimed, and sent";
}

TEST_F(NodeTest, WhatCannotBeSentIsRefused) {
  EXPECT_EQ(rig.node.submit(message(1, 0x40000, 8), rig.now), Refusal::bad_order);
  EXPECT_EQ(rig.node.submit(message(1, 0xEF01, 8), rig.now), Refusal::bad_order);
  EXPECT_EQ(rig.node.submit(message(1, 0xEC00, 8), rig.now), Refusal::bad_order) << "the transport's own";
  EXPECT_EQ(rig.node.submit(message(1, 0xEE00, 8), rig.now), Refusal::bad_order) << "claims are its own";
  Order urgent = message(1, 0xFEF1, 8);
  urgent.priority = 8;
  EXPECT_EQ(rig.node.submit(urgent, rig.now), Refusal::bad_order);
  Order to_one = message(1, 0xFEF1, 8);
  to_one.destination = kOther;
  EXPECT_EQ(rig.node.submit(to_one, rig.now), Refusal::bad_order) << "PDU2 in one frame is for all";
  EXPECT_TRUE(rig.pump().empty());
  to_one.destination = kGlobalAddress;
  EXPECT_EQ(rig.node.submit(to_one, rig.now), Refusal::none);
  urgent.priority = 7;
  EXPECT_EQ(rig.node.submit(urgent, rig.now), Refusal::none);
  EXPECT_EQ(rig.node.submit(message(1, 0xEB00 - 0x100, 8), rig.now), Refusal::none);
}

TEST_F(NodeTest, TheQueueIsBounded) {
  Order one = message(0, 0xFEF1, 1);  // its memory is for all
  for (one.id = 1; one.id <= kMostMessages; ++one.id) ASSERT_EQ(rig.node.submit(one, rig.now), Refusal::none);
  EXPECT_EQ(rig.node.submit(one, rig.now), Refusal::queue_full);
  EXPECT_FALSE(rig.pump().empty());
  EXPECT_EQ(rig.node.submit(one, rig.now), Refusal::none) << "one has been sent";
}

TEST_F(NodeTest, MessagesThatWaitLeaveRoomForRequestsAndTheOtherWayRound) {
  Order one = message(0, 0xFEF1, 1);  // its memory is for all
  for (one.id = 1; one.id <= kMostMessages; ++one.id) ASSERT_EQ(rig.node.submit(one, rig.now), Refusal::none);
  for (OrderId id = 101; id <= 100 + kMostRequests; ++id)
    ASSERT_EQ(rig.node.submit(request(id, 0xFEE5, kOther), rig.now), Refusal::none);
  EXPECT_EQ(rig.node.submit(one, rig.now), Refusal::queue_full);
  EXPECT_EQ(rig.node.submit(request(199, 0xFEE5, kOther), rig.now), Refusal::queue_full);
  EXPECT_EQ(rig.pump().size(), kMostMessages + kMostRequests);
}

TEST_F(NodeTest, AMissedEchoEndsAnOrderAndALaterFrameFreesItsPlace) {
  rig.echoes = false;
  ASSERT_EQ(rig.node.submit(message(1, 0xFEF1, 1), rig.now), Refusal::none);
  (void)rig.run(milliseconds(100));
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer);
  EXPECT_EQ(rig.node.handed_over_count(), 1u);
  rig.echoes = true;
  ASSERT_EQ(rig.node.submit(message(2, 0xFEF2, 1), rig.now), Refusal::none);
  (void)rig.pump();
  EXPECT_EQ(only_answer().outcome, Outcome::done);
  EXPECT_EQ(rig.node.handed_over_count(), 0u);
}

TEST_F(NodeTest, ABusThatTakesNothingIsToldAsTheReason) {
  ASSERT_EQ(rig.node.submit(message(1, 0xFEF1, 1), rig.now), Refusal::none);
  ASSERT_TRUE(rig.node.next_frame());
  rig.node.held_back(Obstacle::bus_off);
  rig.now += milliseconds(100);
  rig.node.advance(rig.now);
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::timeout);
  EXPECT_EQ(answer.obstacle, Obstacle::bus_off);
}

TEST_F(NodeTest, WhatAResetControllerForgotIsNotCalledStopped) {
  rig.echoes = false;
  ASSERT_EQ(rig.node.submit(message(1, 0xFEF1, 8), rig.now), Refusal::none);
  (void)rig.pump();
  rig.node.controller_emptied();
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::no_answer);
  EXPECT_EQ(answer.ended_by, JobEnd::unanswered);
}

TEST_F(NodeTest, StopAnswersEverythingOnce) {
  rig.echoes = false;
  data = counting(20);
  ASSERT_EQ(rig.node.submit({.id = 1, .number = 0xFEF2, .timeout = std::chrono::seconds(9), .memory = data},
                            rig.now),
            Refusal::none);
  (void)rig.pump();
  ASSERT_EQ(rig.node.submit({.id = 2, .number = 0xFEF2, .timeout = std::chrono::seconds(9), .memory = data},
                            rig.now),
            Refusal::none);
  rig.node.stop();
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].outcome, Outcome::no_answer) << "a part of it was handed over";
  EXPECT_EQ(all[0].ended_by, JobEnd::stopped);
  EXPECT_EQ(all[1].outcome, Outcome::stopped);
  EXPECT_EQ(rig.node.submit({.id = 3, .number = 0xFEF2}, rig.now), Refusal::stopped);
}

}  // namespace
}  // namespace j1939::test
