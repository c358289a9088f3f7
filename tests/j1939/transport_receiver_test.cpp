// Messages that are put together out of packets (SAE J1939-21), with their time-outs.
#include "j1939/transport_rig.h"

namespace j1939::test {
namespace {

TEST_F(TransportTest, ABroadcastIsPutTogether) {
  EXPECT_TRUE(rig.hear(frame(0x1CECFF21, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})).empty());
  for (unsigned i = 1; i <= 3; ++i) EXPECT_TRUE(rig.hear(packet_of(0x1CEBFF21, kTwenty, i)).empty());
  ASSERT_EQ(rig.messages.size(), 1u);
  const Got& got = rig.messages[0];
  EXPECT_EQ(got.data, kTwenty);
  EXPECT_EQ(got.message.number, 0xFEF2u);
  EXPECT_EQ(got.message.source, 0x21);
  EXPECT_EQ(got.message.destination, kGlobalAddress);
  EXPECT_EQ(got.message.transport, Transport::broadcast);
  EXPECT_EQ(got.message.priority, 7);
}

TEST_F(TransportTest, AConnectionGetsItsClearToSendAndItsAcknowledgement) {
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})),
            std::vector{frame(0x1CEC2180, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00})});
  EXPECT_TRUE(rig.hear(packet_of(0x1CEB8021, kTwenty, 1)).empty());
  EXPECT_TRUE(rig.hear(packet_of(0x1CEB8021, kTwenty, 2)).empty());
  EXPECT_EQ(rig.hear(packet_of(0x1CEB8021, kTwenty, 3)),
            std::vector{frame(0x1CEC2180, {19, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})});
  ASSERT_EQ(rig.messages.size(), 1u);
  EXPECT_EQ(rig.messages[0].data, kTwenty);
  EXPECT_EQ(rig.messages[0].message.destination, kOwn);
  EXPECT_EQ(rig.messages[0].message.transport, Transport::connection);
}

TEST_F(TransportTest, WindowsAreNoLargerThanTheSenderWants) {
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 2, 0xF2, 0xFE, 0x00})),
            std::vector{frame(0x1CEC2180, {17, 2, 1, 255, 255, 0xF2, 0xFE, 0x00})});
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 1));
  EXPECT_EQ(rig.hear(packet_of(0x1CEB8021, kTwenty, 2)),
            std::vector{frame(0x1CEC2180, {17, 1, 3, 255, 255, 0xF2, 0xFE, 0x00})});
}

TEST_F(TransportTest, TheLongestMessageComesWhole) {
  const auto longest = counting(1785);
  (void)rig.hear(frame(0x1CEC8021, {16, 0xF9, 0x06, 255, 255, 0xF2, 0xFE, 0x00}));
  std::vector<can::Frame> said;
  for (unsigned i = 1; i <= 255; ++i) {
    for (const auto& one : rig.hear(packet_of(0x1CEB8021, longest, i))) said.push_back(one);
  }
  ASSERT_EQ(rig.messages.size(), 1u);
  EXPECT_EQ(rig.messages[0].data, longest);
  ASSERT_EQ(said.size(), 16u) << "15 further windows of 16, and the acknowledgement";
  EXPECT_EQ(said[14], frame(0x1CEC2180, {17, 15, 241, 255, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(said[15], frame(0x1CEC2180, {19, 0xF9, 0x06, 255, 255, 0xF2, 0xFE, 0x00}));
}

TEST_F(TransportTest, AMissedPacketOfAConnectionIsAskedForAgain) {
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 1));
  EXPECT_EQ(rig.hear(packet_of(0x1CEB8021, kTwenty, 3)),
            std::vector{frame(0x1CEC2180, {17, 2, 2, 255, 255, 0xF2, 0xFE, 0x00})});
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 2));
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 3));
  ASSERT_EQ(rig.messages.size(), 1u);
  EXPECT_EQ(rig.messages[0].data, kTwenty);
}

TEST_F(TransportTest, PacketsAreAskedForAgainTwiceAndNoMore) {
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 3));
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 3));
  EXPECT_EQ(rig.hear(packet_of(0x1CEB8021, kTwenty, 3)),
            std::vector{frame(0x1CEC2180, {255, 5, 255, 255, 255, 0xF2, 0xFE, 0x00})});
  EXPECT_EQ(rig.node.received_packets().broken, 1u);
}

TEST_F(TransportTest, ABroadcastWithAGapIsNotTaken) {
  (void)rig.hear(frame(0x1CECFF21, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  (void)rig.hear(packet_of(0x1CEBFF21, kTwenty, 1));
  (void)rig.hear(packet_of(0x1CEBFF21, kTwenty, 3));
  (void)rig.hear(packet_of(0x1CEBFF21, kTwenty, 2));
  EXPECT_TRUE(rig.messages.empty());
  EXPECT_EQ(rig.node.received_packets().broken, 1u);
}

TEST_F(TransportTest, APacketTwiceIsTakenOnce) {
  (void)rig.hear(frame(0x1CECFF21, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  for (const unsigned i : {1u, 1u, 2u, 1u, 2u, 3u}) (void)rig.hear(packet_of(0x1CEBFF21, kTwenty, i));
  ASSERT_EQ(rig.messages.size(), 1u);
  EXPECT_EQ(rig.messages[0].data, kTwenty);
}

TEST_F(TransportTest, T1BetweenPacketsAndT2AfterTheClearToSendEndAConnection) {
  const can::Frame abort = frame(0x1CEC2180, {255, 3, 255, 255, 255, 0xF2, 0xFE, 0x00});
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_TRUE(rig.run(milliseconds(1249)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort}) << "T2";
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 1));
  EXPECT_TRUE(rig.run(milliseconds(749)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort}) << "T1";
  EXPECT_EQ(rig.node.transports(), 0u);
}

TEST_F(TransportTest, ABroadcastThatStopsEndsAfterT1WithoutAWord) {
  (void)rig.hear(frame(0x1CECFF21, {32, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_TRUE(rig.run(milliseconds(750)).empty());
  EXPECT_EQ(rig.node.transports(), 0u);
}

TEST_F(TransportTest, AnotherConnectionOfTheSameNodeIsRefusedAndTheSameBeginsAnew) {
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF3, 0xFE, 0x00})),
            std::vector{frame(0x1CEC2180, {255, 1, 255, 255, 255, 0xF3, 0xFE, 0x00})});
  (void)rig.hear(packet_of(0x1CEB8021, kTwenty, 1));
  EXPECT_EQ(rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00})),
            std::vector{frame(0x1CEC2180, {17, 3, 1, 255, 255, 0xF2, 0xFE, 0x00})});
  EXPECT_EQ(rig.node.transports(), 1u);
}

TEST_F(TransportTest, SessionsAreBoundedWhateverOthersSend) {
  std::size_t refused = 0;
  for (unsigned source = 0; source < 100; ++source) {
    if (source == kOwn) continue;
    const auto said = rig.hear(frame(0x1CEC8000u | source, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
    ASSERT_EQ(said.size(), 1u);
    if (said[0].data[0] == 255) {
      EXPECT_EQ(said[0].data[1], 2) << "no resources";
      ++refused;
    }
  }
  EXPECT_EQ(refused, 100 - TransportReceiver::kSessions);
  EXPECT_EQ(rig.node.transports(), TransportReceiver::kSessions);
}

TEST_F(TransportTest, WhatCannotBeIsRefused) {
  const auto answer_to = [&](int low, int high, int packets) {
    return rig.hear(frame(0x1CEC8021, {16, low, high, packets, 255, 0xF2, 0xFE, 0x00}));
  };
  EXPECT_EQ(answer_to(0xFA, 0x06, 255)[0].data[1], 9) << "1786 bytes";
  EXPECT_EQ(answer_to(20, 0, 4)[0].data[1], 7) << "packets do not fit";
  EXPECT_EQ(answer_to(8, 0, 2)[0].data[1], 7) << "one frame";
  EXPECT_EQ(rig.node.transports(), 0u);
}

TEST_F(TransportTest, TheSenderMayBreakOff) {
  (void)rig.hear(frame(0x1CEC8021, {16, 20, 0, 3, 255, 0xF2, 0xFE, 0x00}));
  (void)rig.hear(frame(0x1CEC8021, {255, 3, 255, 255, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.node.transports(), 0u);
  EXPECT_TRUE(rig.run(seconds(5)).empty());
}

}  // namespace
}  // namespace j1939::test
