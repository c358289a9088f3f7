// Messages in one frame, requests, acknowledgements, and how orders end.
#include "j1939/node.h"

#include <gtest/gtest.h>

#include "j1939/node_rig.h"

namespace j1939::test {
namespace {

class NodeTest : public ::testing::Test {
 protected:
  NodeTest() : rig(settings()) { rig.claimed(); }

  static NodeSettings settings() {
    NodeSettings all = settings_at(kOwn);
    all.provided = {{0xFEE5, 6, counting(8)}, {0xFEEB, 6, counting(20)}, {0xFEEC, 6, {}}};
    return all;
  }
  Order message(OrderId id, Pgn number, std::size_t size) {
    data = counting(size);
    return {.id = id, .number = number, .priority = 3, .timeout = milliseconds(100), .memory = data};
  }
  Order request(OrderId id, Pgn number, Address destination) {
    return {.id = id,
            .kind = OrderKind::request,
            .number = number,
            .destination = destination,
            .timeout = milliseconds(1250),
            .memory = data};
  }
  Answer only_answer() {
    const auto all = rig.answers();
    EXPECT_EQ(all.size(), 1u);
    return all.empty() ? Answer{} : all[0];
  }

  NodeRig rig;
  std::vector<std::uint8_t> data = std::vector<std::uint8_t>(kMostBytes);
};

TEST_F(NodeTest, AMessageInOneFrameIsGivenWithAllItsFields) {
  (void)rig.hear(frame(0x0CF00421, {1, 2, 3, 4, 5, 6, 7, 8}));
  (void)rig.hear(frame(0x18EF8021, {9}));
  (void)rig.hear(frame(0x18EF7021, {9}));  // for another
  ASSERT_EQ(rig.messages.size(), 2u);
  EXPECT_EQ(rig.messages[0].message.number, 0xF004u);
  EXPECT_EQ(rig.messages[0].message.priority, 3);
  EXPECT_EQ(rig.messages[0].message.source, 0x21);
  EXPECT_EQ(rig.messages[0].message.destination, kGlobalAddress);
  EXPECT_EQ(rig.messages[0].data, counting(8));
  EXPECT_EQ(rig.messages[1].message.destination, kOwn);
  EXPECT_EQ(rig.messages[1].data, std::vector<std::uint8_t>{9});
}

TEST_F(NodeTest, FramesThatAreNotJ1939AreCountedAndNothingElse) {
  can::Frame standard = frame(0x123, {1});
  standard.extended = false;
  can::Frame remote = frame(0x18FEF121, {});
  remote.remote = true;
  EXPECT_TRUE(rig.hear(standard).empty());
  EXPECT_TRUE(rig.hear(remote).empty());
  EXPECT_TRUE(rig.messages.empty());
  EXPECT_EQ(rig.node.counters().foreign, 2u);
}

TEST_F(NodeTest, MessagesBetweenOthersOnRequest) {
  NodeSettings all = settings_at(kOwn);
  all.between_others = true;
  NodeRig spy(all);
  spy.claimed();
  (void)spy.hear(frame(0x18EF7021, {9}));
  ASSERT_EQ(spy.messages.size(), 1u);
  EXPECT_EQ(spy.messages[0].message.destination, 0x70);
  EXPECT_EQ(spy.node.counters().messages, 0u);
}

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

TEST_F(NodeTest, RequestsAreBounded) {
  for (OrderId id = 1; id <= kMostRequests; ++id)
    ASSERT_EQ(rig.node.submit(request(id, 0xFEE5, kOther), rig.now), Refusal::none);
  EXPECT_EQ(rig.node.submit(request(99, 0xFEE5, kOther), rig.now), Refusal::queue_full);
  EXPECT_EQ(rig.pump().size(), kMostRequests);
  (void)rig.hear(frame(0x18FEE521, {7}));
  EXPECT_EQ(rig.answers().size(), kMostRequests) << "one answer is the answer to all";
  EXPECT_EQ(rig.node.submit(request(99, 0xFEE5, kOther), rig.now), Refusal::none);
}

TEST_F(NodeTest, ARequestIsDoneWithTheMessageOfTheNodeThatWasAsked) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x18EA2180, {0xE5, 0xFE, 0x00})});
  (void)rig.hear(frame(0x18FEE522, {1}));  // of another
  (void)rig.hear(frame(0x18FEE621, {1}));  // another group
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.hear(frame(0x18FEE521, {4, 5, 6}));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  ASSERT_EQ(answer.size, 3u);
  EXPECT_EQ((std::vector<std::uint8_t>(data.begin(), data.begin() + 3)),
            (std::vector<std::uint8_t>{4, 5, 6}));
}

TEST_F(NodeTest, ARequestIsDoneWithALongMessageToo) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CEC8021, {16, 9, 0, 2, 255, 0xEB, 0xFE, 0x00}));
  (void)rig.hear(frame(0x1CEB8021, {1, 1, 2, 3, 4, 5, 6, 7}));
  (void)rig.hear(frame(0x1CEB8021, {2, 8, 9, 255, 255, 255, 255, 255}));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  EXPECT_EQ(answer.size, 9u);
  EXPECT_EQ(data[8], 9);
}

TEST_F(NodeTest, ARequestThatIsRefusedSaysHow) {
  for (const int control : {1, 2, 3}) {
    ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
    (void)rig.pump();
    (void)rig.hear(frame(0x18E8FF21, {control, 255, 255, 255, 0x81, 0xE5, 0xFE, 0x00}));  // for another
    EXPECT_TRUE(rig.answers().empty());
    (void)rig.hear(frame(0x18E8FF21, {control, 255, 255, 255, 0x80, 0xE5, 0xFE, 0x00}));
    const Answer answer = only_answer();
    EXPECT_EQ(answer.outcome, Outcome::refused);
    EXPECT_EQ(answer.code, control);
  }
  ASSERT_EQ(rig.node.submit(request(2, 0xFEE5, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x18E8FF21, {0, 255, 255, 255, 255, 0xE5, 0xFE, 0x00}));
  const Answer acknowledged = only_answer();
  EXPECT_EQ(acknowledged.outcome, Outcome::done);
  EXPECT_EQ(acknowledged.size, 0u);
}

TEST_F(NodeTest, ARequestThatNobodyAnswersEndsWithItsMonitoringTime) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kOther), rig.now), Refusal::none);
  (void)rig.run(milliseconds(1249));
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.run(milliseconds(1));
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer);
}

/// A broadcast of 30 packets, 200 ms apart, takes 6 s.
TEST_F(NodeTest, ARequestWaitsForTheAnswerThatIsComing) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.run(milliseconds(100));
  (void)rig.hear(frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00}));
  for (int i = 1; i <= 30; ++i) {
    EXPECT_TRUE(rig.answers().empty()) << i;
    (void)rig.run(milliseconds(200));
    (void)rig.hear(frame(0x1CEBFF21, {i, 1, 2, 3, 4, 5, 6, 7}));
  }
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::done);
  EXPECT_EQ(answer.size, 210u);
}

TEST_F(NodeTest, ARequestWaitsForAnAnswerNoLongerThanItIsComing) {
  const can::Frame announcement = frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00});
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.run(milliseconds(1000));
  (void)rig.hear(announcement);
  (void)rig.run(milliseconds(749));
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.run(milliseconds(1));
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "T1";

  ASSERT_EQ(rig.node.submit(request(2, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(announcement);
  for (int i = 0; i < 5; ++i) {
    (void)rig.run(milliseconds(500));
    (void)rig.hear(announcement);
  }
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "who begins again and again does not hold it";

  ASSERT_EQ(rig.node.submit(request(3, 0xFEEB, kOther), rig.now), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CECFF22, {32, 210, 0, 30, 255, 0xEB, 0xFE, 0x00}));
  (void)rig.hear(frame(0x1CECFF21, {32, 210, 0, 30, 255, 0xEC, 0xFE, 0x00}));
  for (int i = 1; i <= 3; ++i) {
    (void)rig.run(milliseconds(500));
    (void)rig.hear(frame(0x1CEBFF22, {i, 1, 2, 3, 4, 5, 6, 7}));
    (void)rig.hear(frame(0x1CEBFF21, {i, 1, 2, 3, 4, 5, 6, 7}));
  }
  EXPECT_EQ(only_answer().outcome, Outcome::no_answer) << "of another node, of another group";
}

TEST_F(NodeTest, ARequestToAllIsDoneWhenItWasSent) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEE5, kGlobalAddress), rig.now), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x18EAFF80, {0xE5, 0xFE, 0x00})});
  EXPECT_EQ(only_answer().outcome, Outcome::done);
}

TEST_F(NodeTest, WithoutAnAddressOnlyTheAddressesOfOthersCanBeAskedFor) {
  NodeSettings listening = settings_at(kOwn);
  listening.claim.preferred.reset();
  NodeRig listener(listening);
  (void)listener.pump();
  EXPECT_EQ(listener.node.submit(request(1, 0xFEE5, kOther), listener.now), Refusal::no_address);
  EXPECT_EQ(listener.node.submit(request(2, 0xEE00, kGlobalAddress), listener.now), Refusal::none);
  EXPECT_EQ(listener.pump(), std::vector{frame(0x18EAFFFE, {0x00, 0xEE, 0x00})});
}

TEST_F(NodeTest, AnswersRequestsForWhatItProvides) {
  EXPECT_EQ(rig.hear(frame(0x18EA8021, {0xE5, 0xFE, 0x00})),
            std::vector{frame(0x18FEE580, {1, 2, 3, 4, 5, 6, 7, 8})});
  EXPECT_EQ(rig.hear(frame(0x18EA8021, {0xEB, 0xFE, 0x00})),
            std::vector{frame(0x18EC2180, {16, 20, 0, 3, 255, 0xEB, 0xFE, 0x00})})
      << "a long one, to who asked";
  EXPECT_EQ(rig.hear(frame(0x18EAFF22, {0xEB, 0xFE, 0x00})),
            std::vector{frame(0x18ECFF80, {32, 20, 0, 3, 255, 0xEB, 0xFE, 0x00})})
      << "asked of all: to all";
  EXPECT_TRUE(rig.hear(frame(0x18EA8021, {0xEC, 0xFE, 0x00})).empty()) << "a client answers";
}

TEST_F(NodeTest, RefusesRequestsForWhatItDoesNotProvideUnlessAllWereAsked) {
  EXPECT_EQ(rig.hear(frame(0x18EA8021, {0xCA, 0xFE, 0x00})),
            std::vector{frame(0x18E8FF80, {1, 255, 255, 255, 0x21, 0xCA, 0xFE, 0x00})});
  EXPECT_TRUE(rig.hear(frame(0x18EAFF21, {0xCA, 0xFE, 0x00})).empty());
}

TEST_F(NodeTest, RequestsOfOthersCannotFillItsMemory) {
  for (int i = 0; i < 1000; ++i) (void)rig.node.receive(frame(0x18EA8021, {0xE5, 0xFE, 0x00}), rig.now);
  EXPECT_EQ(rig.pump().size(), FrameQueue::kMost);
  EXPECT_EQ(rig.node.answers_lost(), 1000 - FrameQueue::kMost);
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

TEST_F(NodeTest, ARequestThatWasOnTheBusIsNotCancelled) {
  ASSERT_EQ(rig.node.submit(request(1, 0xFEEC, 0x21), rig.now), Refusal::none);
  EXPECT_TRUE(rig.node.cancel(1));
  EXPECT_EQ(only_answer().outcome, Outcome::cancelled);
  ASSERT_EQ(rig.node.submit(request(2, 0xFEEC, 0x21), rig.now), Refusal::none);
  (void)rig.pump();
  EXPECT_TRUE(rig.node.cancel(2));
  const Answer answer = only_answer();
  EXPECT_EQ(answer.outcome, Outcome::no_answer) << "the other node may act on it";
  EXPECT_EQ(answer.ended_by, JobEnd::cancelled);
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
