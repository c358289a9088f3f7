// Frames that do not come through: packets that are asked for again, and own frames that are not seen on the
// bus.
#include <gtest/gtest.h>

#include "j1939/node_rig.h"

namespace j1939::test {
namespace {

using std::chrono::seconds;

class LostFrames : public ::testing::Test {
 protected:
  LostFrames() { rig.claimed(); }

  Refusal send(OrderId id, Address destination, std::vector<std::uint8_t>& data) {
    return rig.node.submit({.id = id,
                            .number = 0xFEF2,
                            .priority = 7,
                            .destination = destination,
                            .timeout = seconds(60),
                            .memory = data},
                           rig.now);
  }
  /// A packet of node 0x21, each of whose bytes is the packet's number.
  static can::Frame packet_in(int number) {
    return frame(0x1CEB8021, {number, number, number, number, number, number, number, number});
  }
  static can::Frame clear_to_send(int count, int first) {
    return frame(0x1CEC8021, {17, count, first, 255, 255, 0xF2, 0xFE, 0x00});
  }

  /// A message in one frame, which is handed over and seen on the bus.
  void see_another_frame() {
    ASSERT_EQ(rig.node.submit(
                  {.id = 2, .number = 0xFEF1, .priority = 3, .timeout = milliseconds(100), .memory = another},
                  rig.now),
              Refusal::none);
    EXPECT_EQ(rig.pump().size(), 1u);
  }

  NodeRig rig;
  std::vector<std::uint8_t> another = {1};
};

// --- packets that are asked for again

TEST_F(LostFrames, OneInEachOfManyWindowsIsMadeGood) {
  constexpr int kPackets = 40;
  auto said = rig.hear(frame(0x1CEC8021, {16, (kPackets * 7) & 0xFF, 1, kPackets, 5, 0xF2, 0xFE, 0x00}));
  int lost = 0;
  for (int furthest = 0; said.size() == 1 && said[0].data[0] == 17;) {
    const int first = said[0].data[2];
    const int last = first + said[0].data[1] - 1;
    const bool again = first <= furthest;
    for (int number = first; number <= last; ++number) {
      if (number == first + 2 && !again && number != last) {
        ++lost;
      } else {
        said = rig.hear(packet_in(number));
      }
    }
    furthest = last;
  }
  EXPECT_GT(lost, 2);
  ASSERT_EQ(rig.messages.size(), 1u);
  ASSERT_EQ(rig.messages[0].data.size(), std::size_t{kPackets * 7});
  for (std::size_t i = 0; i < kPackets * 7; ++i) EXPECT_EQ(rig.messages[0].data[i], i / 7 + 1);
}

TEST_F(LostFrames, OneInEachOfManyWindowsIsGivenAgain) {
  std::vector<std::uint8_t> data = counting(140);
  ASSERT_EQ(send(1, kOther, data), Refusal::none);
  (void)rig.pump();
  for (int first = 1; first <= 16; first += 5) {
    EXPECT_EQ(rig.hear(clear_to_send(5, first)).size(), 5u);
    EXPECT_EQ(rig.hear(clear_to_send(3, first + 2)).size(), 3u);
  }
  (void)rig.hear(frame(0x1CEC8021, {19, 140, 0, 20, 255, 0xF2, 0xFE, 0x00}));
  EXPECT_EQ(rig.answers().at(0).outcome, Outcome::done);
}

TEST_F(LostFrames, WhoAsksForEarlierPacketsThanBeforeGainsNoMoreRepeats) {
  std::vector<std::uint8_t> data = counting(140);
  ASSERT_EQ(send(1, kOther, data), Refusal::none);
  (void)rig.pump();
  (void)rig.hear(clear_to_send(5, 1));
  EXPECT_EQ(rig.hear(clear_to_send(1, 3)).size(), 1u);
  EXPECT_EQ(rig.hear(clear_to_send(1, 2)).size(), 1u);
  const auto said = rig.hear(clear_to_send(1, 3));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].data[0], 255);
  EXPECT_EQ(said[0].data[1], 5) << "too many repeats";
}

// --- own frames that are not seen on the bus

/// A frame of it is handed over and not seen, a later one is.
TEST_F(LostFrames, ABroadcastOfWhichAFrameWasNotSeenIsNotDone) {
  std::vector<std::uint8_t> data = counting(20);
  for (const int unseen : {0, 1, 3}) {
    ASSERT_EQ(send(1, kGlobalAddress, data), Refusal::none);
    if (unseen > 0) (void)rig.run(milliseconds(50) * unseen - milliseconds(1));
    rig.echoes = false;
    EXPECT_EQ(rig.run(milliseconds(1)).size(), 1u);
    rig.echoes = true;
    see_another_frame();
    const auto all = rig.answers();
    ASSERT_EQ(all.size(), 2u) << unseen;
    EXPECT_EQ(all[1].id, 1u);
    EXPECT_EQ(all[1].outcome, Outcome::no_answer);
    EXPECT_TRUE(rig.run(seconds(1)).empty()) << "the rest would be of no use";
  }
}

TEST_F(LostFrames, ABroadcastWhoseEchoWasDroppedIsNotDone) {
  std::vector<std::uint8_t> data = counting(20);
  ASSERT_EQ(send(1, kGlobalAddress, data), Refusal::none);
  (void)rig.run(milliseconds(149));
  rig.echoes = false;
  EXPECT_EQ(rig.run(milliseconds(1)).size(), 1u) << "the last packet";
  rig.node.echoes_lost();
  EXPECT_EQ(rig.answers().at(0).outcome, Outcome::no_answer);
}

/// There the receiver tells what it has.
TEST_F(LostFrames, AConnectionGoesOnWhenFramesWereNotSeen) {
  std::vector<std::uint8_t> data = counting(14);
  for (const bool dropped : {false, true}) {
    rig.echoes = false;
    ASSERT_EQ(send(1, kOther, data), Refusal::none);
    EXPECT_EQ(rig.pump().size(), 1u);
    if (dropped) {
      rig.node.echoes_lost();
    } else {
      rig.echoes = true;
      see_another_frame();
      (void)rig.answers();
    }
    rig.echoes = true;
    EXPECT_EQ(rig.hear(clear_to_send(2, 1)).size(), 2u);
    (void)rig.hear(frame(0x1CEC8021, {19, 14, 0, 2, 255, 0xF2, 0xFE, 0x00}));
    EXPECT_EQ(rig.answers().at(0).outcome, Outcome::done);
  }
}

/// An address is nobody's by a claim that nobody heard.
TEST_F(LostFrames, AClaimThatWasNotSeenIsSaidAgain) {
  NodeRig fresh;
  fresh.echoes = false;
  EXPECT_EQ(fresh.pump().size(), 2u) << "the request and the claim";
  fresh.node.echoes_lost();
  EXPECT_EQ(fresh.pump(), std::vector{own_claim(kOwn)});
  (void)fresh.run(milliseconds(250));
  EXPECT_EQ(fresh.node.claim().state(), ClaimState::claiming);
  fresh.node.echoes_lost();
  fresh.echoes = true;
  (void)fresh.run(milliseconds(250));
  EXPECT_EQ(fresh.node.claim().state(), ClaimState::claimed);
}

}  // namespace
}  // namespace j1939::test
