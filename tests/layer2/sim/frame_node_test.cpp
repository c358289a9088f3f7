#include "layer2/sim/frame_node.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <vector>

#include "can/flagged_frames.h"
#include "can/frame_length.h"
#include "sim/line.h"
#include "sim/scripted_node.h"

namespace sim {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using std::chrono::milliseconds;
using test::run_until;
using test::us;

std::vector<std::unique_ptr<Node>> one(FrameNodeSettings settings) {
  std::vector<std::unique_ptr<Node>> nodes;
  nodes.push_back(std::make_unique<FrameNode>(std::move(settings)));
  return nodes;
}

TEST(FrameNode, AnswersRemoteFramesOfItsIdentifiers) {
  const can::Frame answer = data_frame(0x123, {1, 2, 3});
  const can::Frame wide = extended(data_frame(0x18DAF110, {4}));
  Line line({}, one({.answers = {answer, wide}, .answer_time = us(100)}));
  line.send(remote(data_frame(0x123, {0, 0, 0})));
  const auto received = run_until(line, us(1000));
  ASSERT_EQ(received.size(), 2u);
  EXPECT_TRUE(received[0].own);
  EXPECT_EQ(received[1].frame, answer);
  EXPECT_FALSE(received[1].own);
  EXPECT_EQ(received[1].end - received[0].end,
            us(100) + line.bit_times(can::frame_bits(answer) - can::kInterframeBits));
  line.send(extended(remote(data_frame(0x18DAF110, {}))));
  line.send(extended(remote(data_frame(0x123, {}))));  // another width is another identifier
  line.send(data_frame(0x123, {}));
  const auto more = run_until(line, us(3000));
  ASSERT_EQ(more.size(), 4u);
  unsigned foreign = 0;
  for (const auto& one_of_them : more) {
    if (one_of_them.own) continue;
    ++foreign;
    EXPECT_EQ(one_of_them.frame, wide);
  }
  EXPECT_EQ(foreign, 1u);
}

TEST(FrameNode, SendsItsFrameAgainAndAgain) {
  Line line({}, one({.periodic = data_frame(0x080, {254, 7}), .period = milliseconds(1)}));
  const auto received = run_until(line, us(5000));
  ASSERT_EQ(received.size(), 4u);
  for (std::size_t i = 0; i < received.size(); ++i) {
    EXPECT_EQ(received[i].frame, data_frame(0x080, {static_cast<std::uint8_t>(254 + i), 7})) << i;
    if (i == 0) continue;
    const can::Time length = line.bit_times(can::frame_bits(received[i].frame) - can::kInterframeBits);
    EXPECT_EQ(received[i].end - received[i - 1].end, milliseconds(1) + length) << i;
  }
}

TEST(FrameNode, APeriodicFrameWithoutDataHasNoCounter) {
  Line line({}, one({.periodic = remote(data_frame(0x321, {0, 0})), .period = milliseconds(2)}));
  const auto received = run_until(line, us(5000));
  ASSERT_EQ(received.size(), 2u);
  for (const auto& each : received) EXPECT_EQ(each.frame, remote(data_frame(0x321, {0, 0})));
}

}  // namespace
}  // namespace sim
