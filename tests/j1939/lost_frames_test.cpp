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

  NodeRig rig;
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

}  // namespace
}  // namespace j1939::test
