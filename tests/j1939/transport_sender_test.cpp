// Messages that are sent in packets (SAE J1939-21), with their time-outs.
#include "j1939/transport_rig.h"

namespace j1939::test {
namespace {

TEST_F(TransportTest, ABroadcastGoesOutWith50MsBetweenItsPackets) {
  ASSERT_EQ(send(1, kGlobalAddress, twenty), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x1CECFF80, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})});
  for (unsigned i = 1; i <= 3; ++i) {
    EXPECT_TRUE(rig.answers().empty());
    EXPECT_TRUE(rig.run(milliseconds(49)).empty());
    EXPECT_EQ(rig.run(milliseconds(1)), std::vector{packet_out(kTwenty, i, 0xFF)});
  }
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::done);
  EXPECT_EQ(all[0].sent, rig.now);
}

TEST_F(TransportTest, AConnectionWaitsForEachClearToSendAndEndsWithItsAcknowledgement) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(0x1CEC2180, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})});
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {17, 2, 1, 255, 255, 0xF2, 0xFE, 0x00})),
            (std::vector{packet_out(kTwenty, 1, kOther), packet_out(kTwenty, 2, kOther)}));
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {17, 255, 3, 255, 255, 0xF2, 0xFE, 0x00})),
            std::vector{packet_out(kTwenty, 3, kOther)});
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.hear(frame(0x1CEC8021, {19, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::done);
}

TEST_F(TransportTest, T3WithoutAClearToSendOrAcknowledgementBreaksItOff) {
  const can::Frame abort = frame(0x1CEC2180, {255, 3, 255, 255, 255, 0xF2, 0xFE, 0x00});
  for (const bool begun : {false, true}) {
    ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
    (void)rig.pump();
    if (begun) (void)rig.hear(frame(0x1CEC8021, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00}));
    EXPECT_TRUE(rig.run(milliseconds(1249)).empty());
    EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort});
    const auto all = rig.answers();
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].outcome, Outcome::no_answer);
  }
}

TEST_F(TransportTest, AReceiverThatHoldsMustSaySoWithinT4AndCannotHoldBeyondTheMonitoringTime) {
  const can::Frame hold = frame(0x1CEC8021, {17, 0, 255, 255, 255, 0xF2, 0xFE, 0x00});
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(hold);
  EXPECT_TRUE(rig.run(milliseconds(1049)).empty());
  (void)rig.hear(hold);
  EXPECT_TRUE(rig.run(milliseconds(1049)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)).size(), 1u) << "T4";
  EXPECT_EQ(rig.answers()[0].outcome, Outcome::no_answer);
  ASSERT_EQ(send(2, kOther, twenty, seconds(3)), Refusal::none);
  (void)rig.pump();
  for (int i = 0; i < 20 && rig.node.transports() != 0; ++i) {
    (void)rig.hear(hold);
    (void)rig.run(milliseconds(500));
  }
  EXPECT_EQ(rig.node.transports(), 0u);
  EXPECT_EQ(rig.answers()[0].outcome, Outcome::no_answer);
}

TEST_F(TransportTest, PacketsAreGivenAgainTwiceAndNoMore) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  const can::Frame all_three = frame(0x1CEC8021, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00});
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rig.hear(all_three).size(), 3u);
  EXPECT_EQ(rig.hear(all_three), std::vector{frame(0x1CEC2180, {255, 5, 255, 255, 255, 0xF2, 0xFE, 0x00})});
  EXPECT_EQ(rig.answers()[0].outcome, Outcome::no_answer);
}

TEST_F(TransportTest, AClearToSendThatCannotBeBreaksItOff) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {17, 1, 2, 255, 255, 0xF2, 0xFE, 0x00}))[0].data[1], 7)
      << "a packet that was not given cannot be skipped";
  ASSERT_EQ(send(2, kOther, twenty), Refusal::none);
  (void)rig.pump();
  rig.echoes = false;
  (void)rig.hear(frame(0x1CEC8021, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00}));
  const auto said = rig.hear(frame(0x1CEC8021, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00}));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].data[1], 4) << "while packets are being sent";
}

TEST_F(TransportTest, TheReceiverMayBreakOffWithAReason) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CEC8021, {255, 2, 255, 255, 255, 0xF2, 0xFE, 0x00}));
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::aborted);
  EXPECT_EQ(all[0].code, 2);
}

TEST_F(TransportTest, OneMessageAtATimeToEachDestinationAndTheNextWhenItHasEnded) {
  std::vector<std::uint8_t> second = counting(9);
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  ASSERT_EQ(send(2, kOther, second), Refusal::none);
  ASSERT_EQ(send(3, 0x22, second), Refusal::none);
  EXPECT_EQ(rig.pump().size(), 2u) << "one to each";
  EXPECT_EQ(rig.node.waiting(), 1u);
  (void)rig.hear(frame(0x1CEC8021, {255, 2, 255, 255, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.node.waiting(), 0u);
}

TEST_F(TransportTest, MoreThan1785BytesAreNoBroadcast) {
  std::vector<std::uint8_t> longer = counting(1786);
  EXPECT_EQ(send(1, kGlobalAddress, longer), Refusal::too_long_for_all);
}

TEST_F(TransportTest, WithoutEchoesTheMonitoringTimeEndsABroadcast) {
  rig.echoes = false;
  ASSERT_EQ(send(1, kGlobalAddress, twenty, seconds(2)), Refusal::none);
  EXPECT_EQ(rig.run(seconds(2)).size(), 1u);
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::no_answer);
}

TEST_F(TransportTest, AnEmptiedControllerEndsWhatWasBeingSent) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  rig.node.controller_emptied();
  EXPECT_EQ(rig.answers()[0].outcome, Outcome::no_answer);
  EXPECT_EQ(rig.node.transports(), 0u);
}

TEST_F(TransportTest, AMessageOfWhichNothingWentWaitsForTheControllerAsAShortOneDoes) {
  ASSERT_EQ(send(1, kGlobalAddress, twenty, seconds(9)), Refusal::none);
  rig.node.controller_emptied();
  (void)rig.pump();  // asks, and claims
  (void)rig.run(milliseconds(249));
  EXPECT_TRUE(rig.answers().empty());
  const auto begun = rig.run(milliseconds(1));
  ASSERT_EQ(begun.size(), 1u);
  EXPECT_EQ(begun[0].data[0], 32) << "BAM";
}

/// The address may be another node's by now.
TEST_F(TransportTest, AfterAnEmptiedControllerAWaitingMessageWaitsForTheAddressToo) {
  std::vector<std::uint8_t> second = counting(20);
  const auto ask = frame(0x18EAFFFE, {0x00, 0xEE, 0x00});
  for (const Address destination : {kOther, kGlobalAddress}) {
    ASSERT_EQ(send(1, destination, twenty), Refusal::none);
    ASSERT_EQ(send(2, destination, second), Refusal::none);
    (void)rig.pump();
    rig.node.controller_emptied();
    EXPECT_EQ(rig.pump(), (std::vector{ask, own_claim(kOwn)}));
    EXPECT_TRUE(rig.run(milliseconds(249)).empty());
    const auto begun = rig.run(milliseconds(1));
    ASSERT_EQ(begun.size(), 1u);
    EXPECT_EQ(begun[0].data[0], destination == kOther ? 16 : 32) << "RTS or BAM";
    EXPECT_TRUE(rig.node.cancel(2));
    (void)rig.pump();
  }
}

TEST_F(TransportTest, AnEmptiedControllerEndsWhatWasBeingReceivedUntilTheAddressIsClaimedAnew) {
  (void)rig.hear(frame(0x1CEC8022, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.node.transports(), 1u);
  rig.node.controller_emptied();
  EXPECT_EQ(rig.node.transports(), 0u);
  (void)rig.pump();  // the claim
  EXPECT_TRUE(rig.hear(frame(0x1CEB8022, {1, 1, 2, 3, 4, 5, 6, 7})).empty());
  EXPECT_TRUE(rig.hear(frame(0x1CEC8022, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})).empty());
  (void)rig.run(milliseconds(250));
  EXPECT_EQ(rig.hear(frame(0x1CEC8022, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})).size(), 1u) << "clear to send";
}

TEST_F(TransportTest, ALostAddressEndsConnectionsInBothDirections) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(frame(0x1CEC8022, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.node.transports(), 2u);
  (void)rig.hear_claim(kOwn, kStronger);
  EXPECT_EQ(rig.node.transports(), 0u);
  const Answer answer = rig.answers()[0];
  EXPECT_EQ(answer.outcome, Outcome::no_answer) << "its announcement was on the bus";
  EXPECT_EQ(answer.ended_by, JobEnd::lost);
}

TEST_F(TransportTest, ALongMessageCanBeTakenBack) {
  ASSERT_EQ(send(1, kOther, twenty), Refusal::none);
  EXPECT_TRUE(rig.node.cancel(1));
  EXPECT_EQ(rig.answers()[0].outcome, Outcome::cancelled);
  ASSERT_EQ(send(2, kOther, twenty), Refusal::none);
  (void)rig.pump();
  EXPECT_TRUE(rig.node.cancel(2));
  EXPECT_FALSE(rig.node.cancel(2));
  const Answer begun = rig.answers()[0];
  EXPECT_EQ(begun.outcome, Outcome::no_answer) << "its announcement was on the bus";
  EXPECT_EQ(begun.ended_by, JobEnd::cancelled);
  EXPECT_EQ(rig.pump().at(0).data[0], 255) << "the receiver is told";
}

/// Two nodes against each other, every frame of the one heard by the other.
TEST(TransportBetweenTwo, EachLengthAndWindowArrivesWhole) {
  for (const std::size_t size : {9u, 14u, 15u, 255u, 256u, 1784u, 1785u}) {
    for (const unsigned window : {1u, 5u, 255u}) {
      expect_whole_between_two(size, window);
    }
  }
}

}  // namespace
}  // namespace j1939::test
