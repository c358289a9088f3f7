// A device of a script on a bus that is not simulated.

#include "simulator/node_bench.h"

#include <gtest/gtest.h>

#include <memory>

#include "rig.h"
#include "sim/device_script.h"

namespace {

using namespace std::chrono_literals;
using cansync_sim::NodeBench;

std::unique_ptr<sim::Node> device(const char* script) {
  return std::make_unique<sim::ScriptedDevice>(sim::parse_device_script(script, "device").device);
}

std::string next(NodeBench& bench, can::Time now, can::SendResult result = can::SendResult::queued) {
  const auto found = bench.next(now);
  if (!found) return "";
  bench.sent(result);
  return frame_text(*found);
}

TEST(NodeBench, AnswersWhenItsTimeHasCome) {
  NodeBench bench(device("[[answer]]\nto = \"601#40\"\nframe = \"581#43\"\nafter_ms = 2\n"), 0ms);
  EXPECT_EQ(bench.next_due(), can::Time::max());
  bench.receive({frame("602#40"), 1ms, false}, 1ms);
  bench.receive({frame("601#40"), 1ms, false}, 1ms);
  EXPECT_EQ(bench.next_due(), 3ms);
  EXPECT_EQ(next(bench, 2ms), "");
  EXPECT_EQ(next(bench, 3ms), "581#43");
  EXPECT_EQ(next(bench, 3ms), "");
  can::Frame error;
  error.error = true;
  bench.receive({error, 4ms, false}, 4ms);
  EXPECT_EQ(bench.counters().received, 2u);
  EXPECT_EQ(bench.counters().error_frames, 1u);
  EXPECT_EQ(bench.counters().sent, 1u);
}

TEST(NodeBench, SendsByItselfTheLowestIdentifierFirst) {
  NodeBench bench(
      device("[[periodic]]\nframe = \"182#\"\nevery_ms = 10\n[[periodic]]\nframe = \"181#\"\nevery_ms = 5\n"),
      100ms);
  EXPECT_EQ(bench.next_due(), 100ms);
  EXPECT_EQ(next(bench, 100ms), "181#");
  EXPECT_EQ(next(bench, 100ms, can::SendResult::queue_full), "182#");
  EXPECT_EQ(next(bench, 100ms), "");
  EXPECT_EQ(bench.next_due(), 105ms);
  EXPECT_EQ(bench.counters().not_sent, 1u);
}

TEST(NodeBench, WhatWaitsIsDroppedWhenTheInterfaceIsLost) {
  NodeBench bench(device("[[answer]]\nto = \"601#40\"\nframe = \"581#43\"\n"), 0ms);
  bench.receive({frame("601#40"), 1ms, false}, 1ms);
  bench.link_lost();
  EXPECT_EQ(next(bench, 2ms), "");
}

}  // namespace
