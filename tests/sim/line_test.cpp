#include "sim/line.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "can/frame_length.h"
#include "node_list.h"

namespace {

using namespace sim::test;
using can::SendResult;
using can::Time;
using can::Wake;
using sim::Line;
using sim::LineSettings;

TEST(Line, EchoesTheMastersFrameAtTheEndOfItsLastBit) {
  Line line({}, {});
  ASSERT_EQ(line.send(frame("17F#0102030405060708")), SendResult::queued);
  EXPECT_EQ(line.wait_until(us(1000)), Wake::frame);
  can::ReceivedFrame received;
  ASSERT_TRUE(line.receive(received));
  EXPECT_TRUE(received.own);
  EXPECT_EQ(text(received.frame), "17F#0102030405060708");
  EXPECT_EQ(received.end, length("17F#0102030405060708") - us(3));
  EXPECT_EQ(line.now(), received.end);
  EXPECT_FALSE(line.receive(received));
}

TEST(Line, FrameTimesFollowTheBitRate) {
  for (const std::uint32_t rate : {125'000u, 250'000u, 500'000u, 1'000'000u}) {
    Line line({.bits_per_second = rate}, {});
    line.send(frame("100#FFFFFFFFFFFFFFFF"));
    const auto received = run_until(line, us(10'000));
    ASSERT_EQ(received.size(), 1u);
    const unsigned bits = can::frame_bits(frame("100#FFFFFFFFFFFFFFFF")) - 3;
    EXPECT_EQ(received[0].end.count(), std::int64_t{bits} * 1'000'000'000 / rate);
  }
}

TEST(Line, FramesFollowEachOtherWithoutAGap) {
  RecordingTrace trace;
  Line line({.trace = &trace}, {});
  line.send(frame("100#00"));
  line.send(frame("200#FFFF"));
  line.send(frame("300#"));
  run_until(line, us(1000));
  ASSERT_EQ(trace.frames.size(), 3u);
  EXPECT_EQ(trace.frames[0].start, us(0));
  EXPECT_EQ(trace.frames[1].start, length("100#00"));
  EXPECT_EQ(trace.frames[2].start, length("100#00") + length("200#FFFF"));
  EXPECT_EQ(line.counters().busy, length("100#00") + length("200#FFFF") + length("300#"));
  EXPECT_EQ(line.counters().frames, 3u);
}

TEST(Line, MastersFramesLeaveInOrderWhateverTheirIdentifiers) {
  Line line({}, {});
  line.send(frame("500#01"));
  line.send(frame("100#02"));
  line.send(frame("010#03"));
  const auto received = run_until(line, us(1000));
  ASSERT_EQ(received.size(), 3u);
  EXPECT_EQ(text(received[0].frame), "500#01");
  EXPECT_EQ(text(received[1].frame), "100#02");
  EXPECT_EQ(text(received[2].frame), "010#03");
}

TEST(Line, LowestIdentifierWinsTheFreeBus) {
  RecordingTrace trace;
  Nodes nodes;
  const auto others = [](ScriptedNode& node) -> ScriptedNode& { return node.expect("105#00"); };
  others(add<ScriptedNode>(nodes, 1)).reply("381#01").expect("010#AA").expect("302#02").expect("583#03");
  others(add<ScriptedNode>(nodes, 2)).reply("302#02").expect("010#AA").expect("381#01").expect("583#03");
  others(add<ScriptedNode>(nodes, 3)).reply("583#03").expect("010#AA").expect("302#02").expect("381#01");
  Line line({.trace = &trace}, std::move(nodes));
  line.send(frame("105#00"));
  ASSERT_EQ(line.wait_until(us(1000)), Wake::frame);
  line.send(frame("010#AA"));  // handed over while the three wait for the interframe space to end
  run_until(line, us(1000));
  const Time second = length("105#00") + length("010#AA");
  EXPECT_EQ(trace.lines,
            (std::vector<std::string>{
                "0 master 105#00", std::to_string(length("105#00").count()) + " master 010#AA",
                std::to_string(second.count()) + " slave 2 302#02",
                std::to_string((second + length("302#02")).count()) + " slave 1 381#01",
                std::to_string((second + length("302#02") + length("381#01")).count()) + " slave 3 583#03"}));
}

TEST(Line, FrameThatIsNotReadyTakesNoPartInTheArbitration) {
  RecordingTrace trace;
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#00").reply("301#01", us(3.5)).expect("7FF#");
  Line line({.trace = &trace}, std::move(nodes));
  line.send(frame("105#00"));
  line.send(frame("7FF#"));
  run_until(line, us(1000));
  // Half a bit too late for the arbitration: the lowest priority was first.
  ASSERT_EQ(trace.frames.size(), 3u);
  EXPECT_EQ(text(trace.frames[1].frame), "7FF#");
  EXPECT_EQ(text(trace.frames[2].frame), "301#01");
}

TEST(Line, IdleBusIsTakenTheInstantAFrameIsReady) {
  RecordingTrace trace;
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#00").reply("301#01", us(123.456));
  Line line({.trace = &trace}, std::move(nodes));
  line.send(frame("105#00"));
  run_until(line, us(1000));
  ASSERT_EQ(trace.frames.size(), 2u);
  EXPECT_EQ(trace.frames[1].start, length("105#00") - us(3) + us(123.456));
  EXPECT_EQ(trace.frames[1].end, trace.frames[1].start + length("301#01") - us(3));
}

TEST(Line, MasterTakesPartInAnArbitrationAtTheInstantItSends) {
  RecordingTrace trace;
  Nodes nodes;
  const Time ready = us(200) - (length("105#00") - us(3));
  add<ScriptedNode>(nodes, 1).expect("105#00").reply("301#01", ready).expect("100#02");
  Line line({.trace = &trace}, std::move(nodes));
  line.send(frame("105#00"));
  run_until(line, us(200));
  line.send(frame("100#02"));  // both are ready at 200 us exactly
  run_until(line, us(1000));
  ASSERT_EQ(trace.frames.size(), 3u);
  EXPECT_EQ(text(trace.frames[1].frame), "100#02");
  EXPECT_EQ(trace.frames[1].start, us(200));
}

TEST(Line, ArbitrationKnowsRemoteAndExtendedFrames) {
  const auto key = [](std::string_view what) { return sim::arbitration_key(frame(what)); };
  EXPECT_LT(key("123#00"), key("124#00"));
  EXPECT_LT(key("123#00"), key("123#R")) << "data before remote";
  EXPECT_LT(key("123#R"), key("048C0000#00")) << "standard before extended with the same base";
  EXPECT_LT(key("048FFFFF#00"), key("124#00"));
  EXPECT_LT(key("048C0000#00"), key("048C0001#00"));
  EXPECT_LT(key("048C0001#00"), key("048C0001#R"));
}

TEST(Line, TransmitQueueHasItsDepth) {
  Line line({.transmit_queue = 3}, {});
  EXPECT_EQ(line.send(frame("100#")), SendResult::queued);
  EXPECT_EQ(line.send(frame("101#")), SendResult::queued);
  EXPECT_EQ(line.send(frame("102#")), SendResult::queued);
  EXPECT_EQ(line.send(frame("103#")), SendResult::queue_full);
  EXPECT_EQ(run_until(line, us(1)).size(), 0u) << "the first one is on the bus now";
  EXPECT_EQ(line.send(frame("104#")), SendResult::queued);
  EXPECT_EQ(line.send(frame("105#")), SendResult::queue_full);
  EXPECT_EQ(line.status().queue_full, 2u);
  const auto received = run_until(line, us(1000));
  ASSERT_EQ(received.size(), 4u);
  EXPECT_EQ(text(received[3].frame), "104#");
}

TEST(Line, NodesGetWhatTheyAcceptAndNotTheirOwn) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#00").reply("301#01");
  auto& actual = add<ListeningNode>(nodes, 2, 0x300, 0x780);
  auto& all = add<ListeningNode>(nodes, 3);
  Line line({}, std::move(nodes));
  line.send(frame("105#00"));
  const auto received = run_until(line, us(1000));
  ASSERT_EQ(actual.heard.size(), 1u);
  EXPECT_EQ(actual.heard[0].frame, "301#01");
  ASSERT_EQ(all.heard.size(), 2u);
  EXPECT_EQ(all.heard[0].end, received[0].end);
  ASSERT_EQ(received.size(), 2u);
  EXPECT_TRUE(received[0].own);
  EXPECT_FALSE(received[1].own);
}

TEST(Line, NodesHearFramesOfEveryKindThatTheyAccept) {
  Nodes nodes;
  auto& standard = add<ListeningNode>(nodes, 1);
  auto& every = add<ListeningNode>(nodes, 2);
  every.every_kind = true;
  auto& other = add<ListeningNode>(nodes, 3, 0x124, 0x7FF);
  other.every_kind = true;
  Line line({}, std::move(nodes));
  const std::vector<std::string> sent = {"123#01", "123#R2", "00000123#02", "00000123#R", "18DAF110#03"};
  for (const std::string& text : sent) line.send(frame(text));
  run_until(line, us(1000));
  std::vector<std::string> heard;
  for (const auto& one : every.heard) heard.push_back(one.frame);
  EXPECT_EQ(heard, sent);
  ASSERT_EQ(standard.heard.size(), 1u);
  EXPECT_EQ(standard.heard[0].frame, "123#01");
  EXPECT_TRUE(other.heard.empty());
}

TEST(Line, FramesThatNoNodeAcceptsReachTheMaster) {
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line({}, std::move(nodes));
  line.send(frame("00000101#00"));
  line.send(frame("101#R"));
  EXPECT_EQ(run_until(line, us(1000)).size(), 2u);
  EXPECT_TRUE(node.heard.empty());
}

TEST(Line, WaitUntilComesBackAtTheDeadlineOrWithAFrame) {
  Line line({}, {});
  EXPECT_EQ(line.wait_until(us(100)), Wake::deadline);
  EXPECT_EQ(line.now(), us(100));
  EXPECT_EQ(line.wait_until(us(50)), Wake::deadline) << "a deadline in the past";
  EXPECT_EQ(line.now(), us(100)) << "time does not go back";
  line.send(frame("100#"));
  const Time end = us(100) + length("100#") - us(3);
  EXPECT_EQ(line.wait_until(end - us(0.001)), Wake::deadline);
  EXPECT_EQ(line.wait_until(end), Wake::frame) << "at the deadline the frame is there";
  EXPECT_EQ(line.wait_until(end + us(1)), Wake::frame) << "still not received";
  EXPECT_EQ(line.now(), end);
}

TEST(Line, SyncReachesEveryNodeNow) {
  RecordingTrace trace;
  Nodes nodes;
  auto& first = add<ListeningNode>(nodes, 0);
  auto& last = add<ListeningNode>(nodes, 31);
  Line line({.trace = &trace}, std::move(nodes));
  line.wait_until(us(1000));
  line.sync_edge(us(1000));
  line.wait_until(us(2003));
  line.sync_edge(us(2000));
  const std::vector<Time> edges{us(1000), us(2003)};
  EXPECT_EQ(first.syncs, edges);
  EXPECT_EQ(last.syncs, edges);
  EXPECT_EQ(trace.syncs, edges);
  EXPECT_EQ(line.intervals(), 2u);
}

TEST(Line, NodeWithoutRoomInItsControllerDropsFrames) {
  Nodes nodes;
  auto& node = add<ScriptedNode>(nodes, 1);
  for (int i = 0; i < 9; ++i) node.expect("105#").reply("301#", us(5000));
  Line line({}, std::move(nodes));
  for (int i = 0; i < 9; ++i) line.send(frame("105#"));
  run_until(line, us(2000));
  EXPECT_EQ(line.counters().dropped_by_nodes, 1u);
  EXPECT_EQ(run_until(line, us(10'000)).size(), 8u);
}

TEST(Line, WrongSettingsAreRefused) {
  const auto refused = [](const LineSettings& settings, std::size_t count) -> std::string {
    Nodes nodes;
    while (nodes.size() < count) add<ListeningNode>(nodes, 0);
    try {
      const Line line(settings, std::move(nodes));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refused({}, 32), "");
  EXPECT_EQ(refused({}, 33), "simulated line: number of nodes is 33, allowed are 0 to 32");
  EXPECT_EQ(refused({.bits_per_second = 0}, 0),
            "simulated line: bits_per_second is 0, allowed are 10000 to 1000000");
  EXPECT_EQ(refused({.transmit_queue = 0}, 0), "simulated line: transmit_queue is 0, allowed are 1 to 4096");
  EXPECT_EQ(refused({.receive_queue = 0}, 0), "simulated line: receive_queue is 0, allowed are 1 to 65536");
}

// --- real time

TEST(LineInRealTime, FrameEndsAreExactAndNotSeenBefore) {
  Line line({.clock = sim::ClockKind::real_time}, {});
  const Time before = line.now();
  line.send(frame("100#0011223344556677"));
  const Time after = line.now();
  line.send(frame("101#0011223344556677"));
  std::vector<can::ReceivedFrame> received;
  while (received.size() < 2) {
    ASSERT_EQ(line.wait_until(before + std::chrono::seconds(10)), Wake::frame);
    for (const auto& one : receive_all(line)) {
      EXPECT_LE(one.end, line.now());
      received.push_back(one);
    }
  }
  const Time own_length = length("100#0011223344556677") - us(3);
  EXPECT_GE(received[0].end, before + own_length);
  EXPECT_LE(received[0].end, after + own_length);
  EXPECT_GE(received[1].end - received[0].end, length("101#0011223344556677"));
}

TEST(LineInRealTime, LateCallerStillSeesExactInstants) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#00").reply("301#01", us(40));
  Line line({.clock = sim::ClockKind::real_time}, std::move(nodes));
  line.send(frame("105#00"));
  const Time start = line.now();
  while (line.now() < start + us(2000)) {  // not sleeping: the line is not looked at for 2 ms
  }
  const auto received = receive_all(line);
  ASSERT_EQ(received.size(), 2u);
  EXPECT_EQ(text(received[1].frame), "301#01");
  EXPECT_EQ(received[1].end - received[0].end, us(40) + length("301#01") - us(3));
}

TEST(LineInRealTime, FullReceiveQueueIsCounted) {
  Line line({.clock = sim::ClockKind::real_time, .receive_queue = 2}, {});
  for (int i = 0; i < 5; ++i) line.send(frame("100#"));
  const Time start = line.now();
  while (line.now() < start + us(1000)) {  // all five are on the bus before the first is taken
  }
  EXPECT_EQ(line.status().dropped, 3u);
  EXPECT_EQ(receive_all(line).size(), 2u);
}

TEST(LineInRealTime, WaitUntilKeepsAbsoluteDeadlines) {
  Line line({.clock = sim::ClockKind::real_time}, {});
  const Time deadline = line.now() + us(3000);
  EXPECT_EQ(line.wait_until(deadline), Wake::deadline);
  EXPECT_GE(line.now(), deadline);
  EXPECT_EQ(line.wait_until(deadline), Wake::deadline);
}

}  // namespace
