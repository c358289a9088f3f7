// Groups that the node sends by itself.
#include <gtest/gtest.h>

#include "node_rig.h"

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

TEST(Periodic, J13WhatWentByIsLeftOut) {
  NodeRig rig(settings());
  rig.claimed();
  (void)rig.pump();
  rig.now += milliseconds(950);
  EXPECT_EQ(of(rig.pump(), 0x18FEE580).size(), 1u);
  EXPECT_EQ(of(rig.run(milliseconds(49)), 0x18FEE580).size(), 0u);
  EXPECT_EQ(of(rig.run(milliseconds(1)), 0x18FEE580).size(), 1u) << "the grid stays";
}

}  // namespace
}  // namespace j1939::test
