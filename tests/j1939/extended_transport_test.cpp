// The extended transport protocol of SAE J1939-21, in both directions: messages of over 1785 bytes to one
// node.
#include <gtest/gtest.h>

#include "j1939/node_rig.h"

namespace j1939::test {
namespace {

using std::chrono::seconds;

constexpr std::uint32_t kControlIn = 0x1CC88021;   // PGN 0xC800 to the node from 0x21
constexpr std::uint32_t kControlOut = 0x1CC82180;  // and back
constexpr std::uint32_t kDataIn = 0x1CC78021;      // PGN 0xC700
constexpr std::uint32_t kDataOut = 0x1CC72180;

/// 1786 bytes: one more than the plain form carries, in 256 packets.
const std::vector<std::uint8_t> kShortest = counting(1786);

/// Packet `number` of the message, which `sequence` counts within its window.
can::Frame packet_of(std::uint32_t identifier, const std::vector<std::uint8_t>& data, unsigned number,
                     unsigned sequence) {
  can::Frame out = frame(identifier, {static_cast<int>(sequence)});
  out.dlc = 8;
  for (unsigned i = 0; i < 7; ++i) {
    const std::size_t at = (number - 1) * std::size_t{7} + i;
    out.data[i + 1] = at < data.size() ? data[at] : 0xFF;
  }
  return out;
}

class ExtendedTransport : public ::testing::Test {
 protected:
  ExtendedTransport() : rig(settings()) { rig.claimed(); }
  static NodeSettings settings() {
    NodeSettings settings = settings_at(kOwn);
    settings.window = 200;
    settings.most_bytes = 4000;
    return settings;
  }
  Refusal send(OrderId id, Address destination, std::vector<std::uint8_t>& bytes) {
    return rig.node.submit({.id = id,
                            .number = 0xEF00,
                            .priority = 7,
                            .destination = destination,
                            .timeout = seconds(60),
                            .memory = bytes},
                           rig.now);
  }
  /// A connection for 1786 bytes is asked for by node 0x21.
  std::vector<can::Frame> asked() {
    return rig.hear(frame(kControlIn, {20, 0xFA, 0x06, 0, 0, 0x00, 0xEF, 0x00}));
  }
  /// `count` packets follow the first `offset` ones.
  std::vector<can::Frame> offset(int count, int offset) {
    return rig.hear(frame(kControlIn, {22, count, offset & 0xFF, offset >> 8, 0, 0x00, 0xEF, 0x00}));
  }
  static can::Frame abort(int reason, std::uint32_t identifier = kControlOut) {
    return frame(identifier, {255, reason, 255, 255, 255, 0x00, 0xEF, 0x00});
  }

  NodeRig rig;
  std::vector<std::uint8_t> data = kShortest;
};

// RTS (20, size in four bytes), CTS (21, count, next packet in three bytes), offset (22), packets that count
// from 1 after each offset, acknowledgement (23, size).
TEST_F(ExtendedTransport, AMessageComesInWindowsWithTheirOffsets) {
  EXPECT_EQ(asked(), std::vector{frame(kControlOut, {21, 200, 1, 0, 0, 0x00, 0xEF, 0x00})});
  EXPECT_TRUE(offset(200, 0).empty());
  for (unsigned i = 1; i < 200; ++i) EXPECT_TRUE(rig.hear(packet_of(kDataIn, data, i, i)).empty());
  EXPECT_EQ(rig.hear(packet_of(kDataIn, data, 200, 200)),
            std::vector{frame(kControlOut, {21, 56, 201, 0, 0, 0x00, 0xEF, 0x00})});
  EXPECT_TRUE(offset(56, 200).empty());
  for (unsigned i = 201; i < 256; ++i) EXPECT_TRUE(rig.hear(packet_of(kDataIn, data, i, i - 200)).empty());
  EXPECT_EQ(rig.hear(packet_of(kDataIn, data, 256, 56)),
            std::vector{frame(kControlOut, {23, 0xFA, 0x06, 0, 0, 0x00, 0xEF, 0x00})});
  ASSERT_EQ(rig.messages.size(), 1u);
  EXPECT_EQ(rig.messages[0].data, kShortest);
  EXPECT_EQ(rig.messages[0].message.transport, Transport::extended);
  EXPECT_EQ(rig.messages[0].message.destination, kOwn);
  EXPECT_EQ(rig.messages[0].message.number, 0xEF00u);
}

TEST_F(ExtendedTransport, AMissedPacketIsAskedForAgainTwice) {
  (void)asked();
  (void)offset(200, 0);
  const can::Frame again = frame(kControlOut, {21, 200, 2, 0, 0, 0x00, 0xEF, 0x00});
  const can::Frame last = packet_of(kDataIn, data, 200, 200);
  (void)rig.hear(packet_of(kDataIn, data, 1, 1));
  EXPECT_EQ(rig.hear(last), std::vector{again});
  EXPECT_TRUE(rig.hear(packet_of(kDataIn, data, 2, 2)).empty())
      << "of the window before: its offset is missing";
  (void)offset(200, 1);
  EXPECT_EQ(rig.hear(packet_of(kDataIn, data, 201, 200)), std::vector{again});
  (void)offset(200, 1);
  EXPECT_EQ(rig.hear(packet_of(kDataIn, data, 201, 200)), std::vector{abort(5)});
  EXPECT_EQ(rig.node.transports(), 0u);
}

TEST_F(ExtendedTransport, WrongOffsetsBreakItOff) {
  (void)asked();
  EXPECT_EQ(offset(201, 0), std::vector{abort(11)}) << "more than were asked for";
  (void)asked();
  EXPECT_EQ(offset(0, 0), std::vector{abort(11)});
  (void)asked();
  EXPECT_EQ(offset(200, 1), std::vector{abort(12)});
  EXPECT_TRUE(offset(200, 0).empty()) << "nobody has a connection";
  EXPECT_EQ(rig.node.received_packets().broken, 3u);
}

TEST_F(ExtendedTransport, FewerPacketsThanWereAskedForAreTaken) {
  (void)asked();
  (void)offset(2, 0);
  (void)rig.hear(packet_of(kDataIn, data, 1, 1));
  EXPECT_EQ(rig.hear(packet_of(kDataIn, data, 2, 2)),
            std::vector{frame(kControlOut, {21, 200, 3, 0, 0, 0x00, 0xEF, 0x00})});
}

TEST_F(ExtendedTransport, WithoutOffsetOrPacketsTheTimeOutsOfThePlainFormHold) {
  (void)asked();
  EXPECT_TRUE(rig.run(milliseconds(1249)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort(3)}) << "T2";
  (void)asked();
  (void)offset(200, 0);
  EXPECT_TRUE(rig.run(milliseconds(749)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort(3)}) << "T1";
}

// What a peer can fill is bounded: size, connections, memory.
TEST_F(ExtendedTransport, WhatHasNoRoomIsRefusedWithTheReason) {
  const auto asked_by = [&](int source, int low, int high) {
    return rig.hear(
        frame(0x1CC88000u | static_cast<std::uint32_t>(source), {20, low, high, 0, 0, 0x00, 0xEF, 0x00}));
  };
  const auto refused = [](int source, int reason) {
    return std::vector{abort(reason, 0x1CC80080u | static_cast<std::uint32_t>(source) << 8)};
  };
  EXPECT_EQ(asked_by(0x21, 0xA1, 0x0F), refused(0x21, 2)) << "4001 bytes";
  EXPECT_EQ(asked_by(0x21, 0xF9, 0x06), refused(0x21, 7)) << "1785 bytes go by the plain form";
  EXPECT_EQ(asked_by(0x21, 0xA0, 0x0F).size(), 1u);
  EXPECT_EQ(asked_by(0x22, 0xA0, 0x0F).size(), 1u);
  EXPECT_EQ(rig.node.transports(), 2u);
  EXPECT_EQ(asked_by(0x23, 0xA0, 0x0F), refused(0x23, 2)) << "both places are taken";
  EXPECT_EQ(rig.hear(frame(kControlIn, {20, 0xA0, 0x0F, 0, 0, 0x01, 0xFF, 0x00})),
            std::vector{frame(kControlOut, {255, 1, 255, 255, 255, 0x01, 0xFF, 0x00})})
      << "one connection with a node at a time";
  (void)rig.hear(abort(3, kControlIn));
  EXPECT_EQ(asked_by(0x23, 0xA0, 0x0F).at(0).data[0], 21) << "a place is free again";
  EXPECT_EQ(rig.node.received_packets().no_room, 2u);
  EXPECT_EQ(rig.node.received_packets().impossible, 1u);
  EXPECT_EQ(rig.node.received_packets().busy, 1u);
}

TEST_F(ExtendedTransport, TheSameGroupAnewTakesThePlaceOfTheOneBefore) {
  for (int i = 0; i < 5; ++i) EXPECT_EQ(asked().at(0).data[0], 21);
  EXPECT_EQ(rig.node.transports(), 1u);
  EXPECT_EQ(rig.node.received_packets().broken, 4u);
}

// --- sending

TEST_F(ExtendedTransport, EachWindowIsSentBehindItsOffset) {
  ASSERT_EQ(send(1, kOther, data), Refusal::none);
  EXPECT_EQ(rig.pump(), std::vector{frame(kControlOut, {20, 0xFA, 0x06, 0, 0, 0x00, 0xEF, 0x00})});
  auto sent = rig.hear(frame(kControlIn, {21, 2, 1, 0, 0, 0x00, 0xEF, 0x00}));
  EXPECT_EQ(sent, (std::vector{frame(kControlOut, {22, 2, 0, 0, 0, 0x00, 0xEF, 0x00}),
                               packet_of(kDataOut, data, 1, 1), packet_of(kDataOut, data, 2, 2)}));
  sent = rig.hear(frame(kControlIn, {21, 255, 3, 0, 0, 0x00, 0xEF, 0x00}));
  ASSERT_EQ(sent.size(), 255u);
  EXPECT_EQ(sent[0], frame(kControlOut, {22, 254, 2, 0, 0, 0x00, 0xEF, 0x00})) << "256 packets in all";
  EXPECT_EQ(sent[1], packet_of(kDataOut, data, 3, 1));
  EXPECT_EQ(sent[254], packet_of(kDataOut, data, 256, 254));
  sent = rig.hear(frame(kControlIn, {21, 1, 0, 1, 0, 0x00, 0xEF, 0x00}));
  EXPECT_EQ(sent, (std::vector{frame(kControlOut, {22, 1, 255, 0, 0, 0x00, 0xEF, 0x00}),
                               packet_of(kDataOut, data, 256, 1)}))
      << "the last one again: its number takes two bytes";
  EXPECT_TRUE(rig.answers().empty());
  (void)rig.hear(frame(kControlIn, {23, 0xFA, 0x06, 0, 0, 0x00, 0xEF, 0x00}));
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::done);
}

TEST_F(ExtendedTransport, TheOtherFormsAnswersAreNotItsOwn) {
  ASSERT_EQ(send(1, kOther, data), Refusal::none);
  (void)rig.pump();
  EXPECT_TRUE(rig.hear(frame(0x1CEC8021, {17, 2, 1, 255, 255, 0x00, 0xEF, 0x00})).empty());
  EXPECT_TRUE(rig.hear(frame(0x1CEC8021, {255, 1, 255, 255, 255, 0x00, 0xEF, 0x00})).empty());
  EXPECT_EQ(rig.node.transports(), 1u);
  (void)rig.hear(abort(2, kControlIn));
  const auto all = rig.answers();
  ASSERT_EQ(all.size(), 1u);
  EXPECT_EQ(all[0].outcome, Outcome::aborted);
  EXPECT_EQ(all[0].code, 2);
}

TEST_F(ExtendedTransport, AReceiverThatIsSilentOrAsksForTooMuchEndsIt) {
  ASSERT_EQ(send(1, kOther, data), Refusal::none);
  (void)rig.pump();
  EXPECT_TRUE(rig.run(milliseconds(1249)).empty());
  EXPECT_EQ(rig.run(milliseconds(1)), std::vector{abort(3)}) << "T3";
  EXPECT_EQ(rig.answers().at(0).outcome, Outcome::no_answer);
  ASSERT_EQ(send(2, kOther, data), Refusal::none);
  (void)rig.pump();
  EXPECT_EQ(rig.hear(frame(kControlIn, {21, 1, 1, 1, 0, 0x00, 0xEF, 0x00})), std::vector{abort(7)})
      << "packet 257 of 256";
  EXPECT_EQ(rig.answers().at(0).outcome, Outcome::no_answer);
}

TEST_F(ExtendedTransport, WhatCannotBeSentIsRefused) {
  std::vector<std::uint8_t> longer(4001);
  EXPECT_EQ(send(1, kOther, longer), Refusal::too_long);
  longer.resize(4000);
  EXPECT_EQ(send(2, kGlobalAddress, longer), Refusal::too_long_for_all) << "it knows no broadcast";
  EXPECT_EQ(send(3, kOther, longer), Refusal::none);
  EXPECT_TRUE(rig.node.cancel(3));

  NodeSettings more = settings();
  more.most_bytes = 4001;
  NodeRig other(more);
  other.claimed();
  longer.resize(4001);
  EXPECT_EQ(other.node.submit({.id = 1,
                               .number = 0xEF00,
                               .priority = 7,
                               .destination = kOther,
                               .timeout = seconds(60),
                               .memory = longer},
                              other.now),
            Refusal::none);
}

/// Two nodes against each other, each frame of the one heard by the other; 64 KiB need numbers of two bytes.
TEST(ExtendedTransportBetweenTwo, EachLengthAndWindowArrivesWhole) {
  for (const std::size_t size : {1786u, 1792u, 1793u, 4096u, 65'536u}) {
    for (const unsigned window : {1u, 16u, 255u}) {
      expect_whole_between_two(size, window);
    }
  }
}

}  // namespace
}  // namespace j1939::test
