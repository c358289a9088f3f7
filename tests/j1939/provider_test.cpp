// Groups that the node provides: those that it sends periodically, and answers to requests.
#include "j1939/provider.h"

#include "j1939/node_fixture.h"

namespace j1939::test {
namespace {

NodeSettings settings() {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEE5, 6, counting(4), milliseconds(100)}, {0xFEE6, 6, counting(8)}};
  return all;
}

std::vector<can::Frame> of(const std::vector<can::Frame>& frames, std::uint32_t identifier) {
  std::vector<can::Frame> found;
  for (const can::Frame& one : frames)
    if (one.id == identifier) found.push_back(one);
  return found;
}

TEST(Periodic, J13AGroupIsSentAtItsPeriodWithTheClaimedAddress) {
  NodeRig rig(settings());
  EXPECT_TRUE(of(rig.run(milliseconds(249)), 0x18FEE580).empty()) << "no address is held yet";
  const auto sent = of(rig.run(milliseconds(1001)), 0x18FEE580);
  EXPECT_EQ(sent.size(), 11u) << "at 250 ms, and each 100 ms after it up to 1250";
  EXPECT_EQ(sent.at(0), frame(0x18FEE580, {1, 2, 3, 4}));
  EXPECT_TRUE(of(rig.run(milliseconds(1000)), 0x18FEE680).empty()) << "that one has no period";
}

TEST(Periodic, J13TheNewAddressIsThatOfTheGroupsAndWithoutOneNoneIsSent) {
  NodeRig rig(settings());
  rig.claimed();
  (void)rig.hear_claim(kOwn, kStronger);
  auto sent = rig.run(milliseconds(1000));
  EXPECT_TRUE(of(sent, 0x18FEE580).empty()) << "it was lost";
  const auto address = rig.node.claim().address();
  ASSERT_TRUE(address);
  EXPECT_FALSE(of(sent, 0x18FEE500u | *address).empty());
  NodeSettings fixed = settings();
  NameFields fields = kFields;
  fields.arbitrary_address = false;
  fixed.claim.name = compose(fields);
  NodeRig without(fixed);
  without.claimed();
  (void)without.hear_claim(kOwn, kStronger);
  sent = without.run(milliseconds(1000));
  EXPECT_TRUE(of(sent, 0x18FEE580).empty());
}

TEST(Periodic, J13AMessageInPacketsIsABroadcast) {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEEB, 6, counting(20), milliseconds(1000)}};
  NodeRig rig(all);
  const auto sent = rig.run(milliseconds(2750));
  EXPECT_EQ(of(sent, 0x18ECFF80).size(), 3u) << "announcements, at 0.25, 1.25 and 2.25 s";
  EXPECT_EQ(of(sent, 0x18EBFF80).size(), 9u) << "of three packets each";
}

TEST(Periodic, LongGroupsOfOnePeriodAreSentOneAfterTheOther) {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEEB, 6, counting(10), milliseconds(1000)},
                  {0xFEDA, 6, counting(12), milliseconds(1000)}};
  NodeRig rig(all);
  std::size_t first = 0;
  std::size_t second = 0;
  for (const can::Frame& one : of(rig.run(milliseconds(10'500)), 0x18ECFF80)) {
    first += one.data[5] == 0xEB;
    second += one.data[5] == 0xDA;
  }
  EXPECT_EQ(first, 11u);
  EXPECT_EQ(second, 11u);
  EXPECT_EQ(rig.node.groups_left_out(), 0u);
}

// 1785 bytes take 12.8 s.
TEST(Periodic, WhatTheGroupBeforeLeavesNoRoomForIsCounted) {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEEB, 6, counting(1785), milliseconds(1000)}};
  NodeRig rig(all);
  EXPECT_EQ(of(rig.run(milliseconds(20'000)), 0x18ECFF80).size(), 2u);
  EXPECT_EQ(rig.node.groups_left_out(), 17u) << "two were begun and one waits, of 20";
}

TEST(Periodic, ClientsWhoAlwaysBroadcastLeaveItsTurnToAGroup) {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEEB, 6, counting(10), milliseconds(1000)}};
  NodeRig rig(all);
  rig.claimed();
  std::vector<std::uint8_t> data = counting(100);
  std::size_t groups = 0;
  std::size_t orders = 0;
  for (OrderId id = 1; id <= 30; ++id) {
    const Order order{.id = id, .number = 0xFEF1, .timeout = std::chrono::seconds(60), .memory = data};
    ASSERT_EQ(rig.node.submit(order, rig.now), Refusal::none);
    for (const can::Frame& one : of(rig.run(milliseconds(500)), 0x18ECFF80)) groups += one.data[5] == 0xEB;
    orders += rig.answers().size();
  }
  EXPECT_GE(groups, 8u) << "once between two of the client's, of 0.85 s each";
  EXPECT_GE(orders, 8u);
}

// J1939-21: a node sends its broadcasts one after the other.
TEST(Periodic, TwoLongGroupsThatAreAskedForAtOnceAreBothAnswered) {
  NodeSettings all = settings_at(kOwn);
  all.provided = {{0xFEEB, 6, counting(20)}, {0xFEDA, 6, counting(12)}};
  NodeRig rig(all);
  rig.claimed();
  std::vector<can::Frame> sent = rig.hear(frame(0x18EAFF21, {0xEB, 0xFE, 0x00}));
  for (const can::Frame& one : rig.hear(frame(0x18EAFF21, {0xDA, 0xFE, 0x00}))) sent.push_back(one);
  for (const can::Frame& one : rig.run(milliseconds(500))) sent.push_back(one);
  const auto announced = of(sent, 0x18ECFF80);
  ASSERT_EQ(announced.size(), 2u);
  EXPECT_EQ(announced[0].data[5], 0xEB);
  EXPECT_EQ(announced[1].data[5], 0xDA);
  // Of one node, which answers for both: no "cannot respond".
  sent = rig.hear(frame(0x18EA8021, {0xEB, 0xFE, 0x00}));
  for (const can::Frame& one : rig.hear(frame(0x18EA8021, {0xDA, 0xFE, 0x00}))) sent.push_back(one);
  EXPECT_TRUE(of(sent, 0x18E8FF80).empty());
  EXPECT_EQ(of(sent, 0x18EC2180).size(), 1u);
  sent = rig.hear(frame(0x1CEC8021, {19, 20, 0, 3, 0xFF, 0xEB, 0xFE, 0x00}));
  EXPECT_EQ(of(sent, 0x18EC2180).size(), 0u) << "not all packets were asked for";
}

TEST(Periodic, J13WhatWentByIsLeftOut) {
  NodeRig rig(settings());
  rig.claimed();
  (void)rig.pump();
  rig.now += milliseconds(950);
  EXPECT_EQ(of(rig.pump(), 0x18FEE580).size(), 1u);
  EXPECT_EQ(of(rig.run(milliseconds(49)), 0x18FEE580).size(), 0u);
  EXPECT_EQ(of(rig.run(milliseconds(1)), 0x18FEE580).size(), 1u) << "the grid stays";
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

}  // namespace
}  // namespace j1939::test
