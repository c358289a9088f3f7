// What a node takes of the bus.
#include "j1939/node.h"

#include <utility>

#include "j1939/node_fixture.h"

namespace j1939::test {
namespace {

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

TEST_F(NodeTest, WhatHasNotTheBytesOfItsGroupIsCountedByKind) {
  const auto counts = [&] {
    return std::pair(rig.node.counters().wrong_length, rig.node.counters().unknown);
  };
  for (const can::Frame& wrong : {
           frame(0x18EEFF21, {1, 2, 3, 4, 5, 6, 7}),    // a claim of 7 bytes
           frame(0x18EA8021, {0xEB, 0xFE}),             // a request of 2
           frame(0x18E88021, {0, 255, 255, 255, 255}),  // an acknowledgement of 5
           frame(0x1CEC8021, {16, 20, 0, 3}),           // an RTS of 4
           frame(0x18ECFF21, {}),                       // nothing, to all
       }) {
    const auto before = counts();
    EXPECT_TRUE(rig.hear(wrong).empty());
    EXPECT_EQ(counts(), std::pair(before.first + 1, before.second)) << wrong.id;
  }
  for (const can::Frame& unknown : {
           frame(0x18E88021, {4, 255, 255, 255, 0x80, 0xEB, 0xFE, 0}),  // an acknowledgement of kind 4
           frame(0x1CEC8021, {18, 20, 0, 3, 255, 0xEB, 0xFE, 0}),       // no control byte of the standard
           frame(0x1CC88021, {16, 20, 0, 3, 255, 0xEB, 0xFE, 0}),       // RTS in the extended form's group
       }) {
    const auto before = counts();
    EXPECT_TRUE(rig.hear(unknown).empty());
    EXPECT_EQ(counts(), std::pair(before.first, before.second + 1)) << unknown.id;
  }
  const auto before = counts();
  (void)rig.hear(frame(0x1CEC7021, {18, 20, 0, 3, 255, 0xEB, 0xFE, 0}));
  EXPECT_EQ(counts(), before) << "for another node";
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

}  // namespace
}  // namespace j1939::test
