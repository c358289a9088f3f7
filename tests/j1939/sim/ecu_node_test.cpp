// A simulated node of J1939 on the simulated line, byte by byte.
#include "j1939/sim/ecu_node.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <vector>

#include "j1939/node_rig.h"
#include "sim/line.h"
#include "sim/scripted_node.h"

namespace sim {
namespace {

using j1939::test::counting;
using j1939::test::frame;
using std::chrono::milliseconds;

EcuSettings engine() {
  EcuSettings settings;
  settings.claim.preferred = 0x21;
  settings.claim.name = 0x1234;
  settings.group = 0xFEF1;
  settings.data = counting(3);
  return settings;
}

std::vector<std::unique_ptr<Node>> alone(EcuSettings settings) {
  std::vector<std::unique_ptr<Node>> nodes;
  nodes.push_back(std::make_unique<EcuNode>(std::move(settings)));
  return nodes;
}

/// What the node sends until then.
std::vector<can::Frame> sent_until(Line& line, can::Time end) {
  std::vector<can::Frame> frames;
  for (const auto& received : test::run_until(line, end)) {
    if (!received.own) frames.push_back(received.frame);
  }
  return frames;
}

TEST(EcuNode, ClaimsItsAddressAndGivesWhatItIsAskedFor) {
  Line line({.bits_per_second = 250'000}, alone(engine()));
  EXPECT_EQ(sent_until(line, milliseconds(300)),
            (std::vector{frame(0x18EAFFFE, {0x00, 0xEE, 0x00}),
                         frame(0x18EEFF21, {0x34, 0x12, 0, 0, 0, 0, 0, 0})}));
  line.send(frame(0x18EA2180, {0xF1, 0xFE, 0x00}));
  EXPECT_EQ(sent_until(line, milliseconds(310)), std::vector{frame(0x18FEF121, {1, 2, 3})});
  line.send(frame(0x18EA2180, {0xF2, 0xFE, 0x00}));
  EXPECT_EQ(sent_until(line, milliseconds(320)),
            std::vector{frame(0x18E8FF21, {1, 255, 255, 255, 0x80, 0xF2, 0xFE, 0x00})});
}

TEST(EcuNode, SendsItsMessageAgainAndAgainAndItsFirstByteCounts) {
  EcuSettings settings = engine();
  settings.period = milliseconds(300);
  Line line({.bits_per_second = 250'000}, alone(settings));
  const auto frames = sent_until(line, milliseconds(1000));
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[2], frame(0x18FEF121, {2, 2, 3}));
  EXPECT_EQ(frames[4], frame(0x18FEF121, {4, 2, 3}));
}

// DM1 of one fault, J1939-73: amber lamp, SPN 110, FMI 16, 3 occurrences. A count would change its lamps.
TEST(EcuNode, WithoutACountItsMessageStaysAsItIs) {
  EcuSettings settings = engine();
  settings.group = 0xFECA;
  settings.data = {0x04, 0xFF, 0x6E, 0x00, 0x10, 0x03, 0xFF, 0xFF};
  settings.period = milliseconds(300);
  settings.counts = false;
  Line line({.bits_per_second = 250'000}, alone(settings));
  const auto frames = sent_until(line, milliseconds(1000));
  ASSERT_EQ(frames.size(), 5u);
  const can::Frame fault = frame(0x18FECA21, {0x04, 0xFF, 0x6E, 0x00, 0x10, 0x03, 0xFF, 0xFF});
  EXPECT_EQ(frames[2], fault);
  EXPECT_EQ(frames[4], fault);
}

TEST(EcuNode, ItsLongMessageIsABroadcast) {
  EcuSettings settings = engine();
  settings.data = counting(9);
  settings.period = milliseconds(300);
  Line line({.bits_per_second = 250'000}, alone(settings));
  const auto frames = sent_until(line, milliseconds(500));
  ASSERT_EQ(frames.size(), 5u);
  EXPECT_EQ(frames[2], frame(0x18ECFF21, {32, 9, 0, 2, 255, 0xF1, 0xFE, 0x00}));
  EXPECT_EQ(frames[3], frame(0x18EBFF21, {1, 2, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(frames[4], frame(0x18EBFF21, {2, 8, 9, 255, 255, 255, 255, 255}));
}

}  // namespace
}  // namespace sim
