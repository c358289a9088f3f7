#include "sim/faults.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "cansync/sim/drive_faults.h"
#include "node_list.h"
#include "sim/line.h"

namespace {

using namespace sim::test;
using can::ControllerState;
using can::Time;
using sim::FaultKind;
using sim::Line;

constexpr unsigned kErrorBits = 18;  // 6 flag, 1 later flags of the others, 8 delimiter, 3 interframe space

TEST(Faults, LostFrameReachesNobodyButItsSenderDoesNotKnow) {
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line({.faults = {{.kind = FaultKind::lost, .count = 1}}}, std::move(nodes));
  line.send(frame("101#00"));
  line.send(frame("102#00"));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"101#00", "102#00"})) << "echoes of both";
  EXPECT_EQ(heard(node), (Texts{"102#00"}));
  EXPECT_EQ(line.faults().hits(0), 1u);
  EXPECT_EQ(line.counters().lost_deliveries, 1u);
}

TEST(Faults, LostToSomeReceivers) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#").reply("301#01").expect("106#");
  auto& second = add<ListeningNode>(nodes, 2, 0x300, 0x780);
  auto& third = add<ListeningNode>(nodes, 3, 0x300, 0x780);
  Line line({.faults = {{.kind = FaultKind::lost,
                         .identifier = 0x300,
                         .mask = 0x780,
                         .receivers = sim::NodeSet::of(2),
                         .lost_to_master = false}}},
            std::move(nodes));
  line.send(frame("105#"));
  line.send(frame("106#"));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"105#", "106#", "301#01"}));
  EXPECT_TRUE(second.heard.empty());
  EXPECT_EQ(heard(third), (Texts{"301#01"}));
}

TEST(Faults, LostToTheMasterAlone) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#").reply("301#01");
  auto& second = add<ListeningNode>(nodes, 2, 0x300, 0x780);
  Line line(
      {.faults = {{.kind = FaultKind::lost, .node = 1, .receivers = {}}}, .protocol = &sim::drive_faults()},
      std::move(nodes));
  line.send(frame("105#"));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"105#"}));
  EXPECT_EQ(heard(second), (Texts{"301#01"}));
}

TEST(Faults, LateFramesOfNodeAndMaster) {
  RecordingTrace trace;
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("500#00").reply("581#01");
  Line line({.faults = {{.kind = FaultKind::late, .node = 1, .delay = us(70)},
                        {.kind = FaultKind::late, .identifier = 0x500, .mask = 0x7FF, .delay = us(30)}},
             .protocol = &sim::drive_faults(),
             .trace = &trace},
            std::move(nodes));
  line.send(frame("500#00"));
  run_until(line, us(1000));
  ASSERT_EQ(trace.frames.size(), 2u);
  EXPECT_EQ(trace.frames[0].start, us(30));
  EXPECT_EQ(trace.frames[1].start, us(30) + length("500#00") - us(3) + us(70));
}

TEST(Faults, CorruptedFrameIsSentAgainAfterAnErrorFrame) {
  RecordingTrace trace;
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line({.faults = {{.kind = FaultKind::corrupted, .count = 1}}, .trace = &trace}, std::move(nodes));
  line.send(frame("105#0011"));
  line.wait_until(us(80));
  EXPECT_EQ(line.status().transmit_errors, 8u);
  EXPECT_EQ(line.node_status(0).receive_errors, 1u);
  const auto received = run_until(line, us(1000));
  // Whole frame but its 13 bits after the CRC, then the error frame, then the frame again.
  const Time flag = length("105#0011") - us(13);
  const Time again = flag + us(kErrorBits);
  EXPECT_EQ(trace.lines, (Texts{std::to_string(flag.count()) + " master 20000008#0000000000000000",
                                std::to_string(again.count()) + " master 105#0011"}));
  ASSERT_EQ(received.size(), 1u);
  EXPECT_EQ(received[0].end, again + length("105#0011") - us(3));
  EXPECT_EQ(node.heard.size(), 1u);
  EXPECT_EQ(line.counters().error_frames, 1u);
  EXPECT_EQ(line.status().transmit_errors, 7u) << "the repetition went well";
  EXPECT_EQ(line.node_status(0).receive_errors, 0u);
}

TEST(Faults, CorruptedFrameCompetesAgain) {
  RecordingTrace trace;
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#").reply("301#", us(10)).expect("7F0#");
  Line line(
      {.faults = {{.kind = FaultKind::corrupted, .from = 0, .count = 1, .identifier = 0x7F0, .mask = 0x7FF}},
       .trace = &trace},
      std::move(nodes));
  line.send(frame("105#"));
  line.send(frame("7F0#"));  // destroyed while the node's frame becomes ready, which then goes first
  EXPECT_EQ(texts(run_until(line, us(59))), (Texts{"105#"}));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"301#", "7F0#"}));
}

TEST(Faults, ErrorCountersFollowTheStandardUpToBusOff) {
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line({.faults = {{.kind = FaultKind::corrupted, .count = 40}}}, std::move(nodes));
  line.send(frame("105#"));
  line.send(frame("106#"));
  std::vector<ControllerState> states;
  for (int step = 0; step < 4000; ++step) {
    EXPECT_EQ(line.wait_until(us(step)), can::Wake::deadline);
    const auto status = line.status();
    if (states.empty() || states.back() != status.state) states.push_back(status.state);
    EXPECT_EQ(status.state >= ControllerState::error_warning, status.transmit_errors >= 96);
    EXPECT_EQ(status.state >= ControllerState::error_passive, status.transmit_errors >= 128);
  }
  EXPECT_EQ(states,
            (std::vector<ControllerState>{ControllerState::error_active, ControllerState::error_warning,
                                          ControllerState::error_passive, ControllerState::bus_off}));
  EXPECT_EQ(line.faults().hits(0), 32u) << "256 / 8 failures";
  EXPECT_EQ(line.status().transmit_errors, 256u);
  EXPECT_EQ(line.send(frame("107#")), can::SendResult::bus_off);
  EXPECT_TRUE(node.heard.empty());
}

TEST(Faults, ResetLeavesBusOffAfterTheRecoveryTime) {
  Line line({.faults = {{.kind = FaultKind::corrupted, .count = 32}}}, {});
  line.send(frame("105#"));
  run_until(line, us(5000));
  ASSERT_EQ(line.status().state, ControllerState::bus_off);
  run_until(line, us(100'000));
  EXPECT_EQ(line.status().state, ControllerState::bus_off) << "not by itself";
  EXPECT_EQ(line.reset(), can::ResetResult::done);
  run_until(line, us(100'000 + 1407));
  EXPECT_EQ(line.send(frame("106#")), can::SendResult::bus_off);
  run_until(line, us(100'000 + 1408));  // 128 * 11 bits
  EXPECT_EQ(line.status().state, ControllerState::error_active);
  EXPECT_EQ(line.status().transmit_errors, 0u);
  EXPECT_EQ(line.status().restarts, 1u);
  EXPECT_EQ(line.status().error_frames, line.counters().error_frames);
  EXPECT_GE(line.status().error_frames, 32u);
  EXPECT_EQ(line.send(frame("107#")), can::SendResult::queued);
  EXPECT_EQ(texts(run_until(line, us(110'000))), (Texts{"107#"})) << "what waited before is gone";
}

TEST(Faults, ResetDropsWhatWaitsAndTheFrameOnTheBus) {
  Line line({}, {});
  line.send(frame("105#"));
  line.send(frame("106#"));
  run_until(line, us(10));
  EXPECT_EQ(line.reset(), can::ResetResult::done);
  line.send(frame("107#"));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"107#"}));
}

TEST(Faults, NodeInBusOffComesBackByItself) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("105#").reply("301#").expect("107#").reply("302#");
  Line line(
      {.faults = {{.kind = FaultKind::corrupted, .count = 32, .node = 1}}, .protocol = &sim::drive_faults()},
      std::move(nodes));
  line.send(frame("105#"));
  run_until(line, us(60));
  // Its frame and the error frame after it, 32 times; then nothing of it is on the bus.
  const Time attempt = length("301#") - us(13) + us(kErrorBits);
  const Time off = length("105#") + 32 * attempt;
  run_until(line, off);
  EXPECT_EQ(line.node_status(0).state, ControllerState::bus_off);
  line.send(frame("106#"));  // it does not hear this one
  run_until(line, off + us(1408));
  line.send(frame("107#"));
  EXPECT_EQ(texts(run_until(line, off + us(5000))), (Texts{"107#", "302#"}));
  EXPECT_EQ(line.node_status(0).state, ControllerState::error_active);
}

TEST(Faults, DuplicatedFrameIsHeardTwiceAndEchoedOnce) {
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line({.faults = {{.kind = FaultKind::duplicated, .count = 1}}}, std::move(nodes));
  line.send(frame("105#22"));
  line.send(frame("106#"));
  EXPECT_EQ(texts(run_until(line, us(1000))), (Texts{"105#22", "106#"}));
  EXPECT_EQ(heard(node), (Texts{"105#22", "105#22", "106#"}));
  EXPECT_EQ(node.heard[1].end - node.heard[0].end, us(kErrorBits) + length("105#22") - us(3));
}

TEST(Faults, SilentSlaveIsGoneFromTheBusAndReturns) {
  RecordingTrace trace;
  Nodes nodes;
  add<ScriptedNode>(nodes, 1).expect("101#").reply("301#").expect("101#").reply("301#");
  auto& other = add<ListeningNode>(nodes, 2, 0x100, 0x780);
  Line line({.faults = {{.kind = FaultKind::silent, .from = 1, .to = 2, .node = 1}}, .trace = &trace},
            std::move(nodes));
  Texts received;
  for (int interval = 0; interval < 4; ++interval) {
    line.sync_edge(us(1000 * interval));
    line.send(frame("101#"));
    for (const auto& one : texts(run_until(line, us(1000 * interval + 1000)))) received.push_back(one);
  }
  EXPECT_EQ(received, (Texts{"101#", "301#", "101#", "101#", "101#", "301#"}));
  EXPECT_EQ(other.heard.size(), 4u);
  EXPECT_EQ(line.faults().hits(0), 2u);
}

TEST(Faults, SilentSlaveGetsNoSyncAndLosesWhatItWantedToSend) {
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1, 0x101, 0x7FF);
  add<ScriptedNode>(nodes, 2).expect("102#").reply("302#", us(1500));
  Line line({.faults = {{.kind = FaultKind::silent, .from = 1, .to = 1, .node = 1},
                        {.kind = FaultKind::silent, .from = 1, .to = 1, .node = 2}}},
            std::move(nodes));
  for (int interval = 0; interval < 3; ++interval) {
    line.sync_edge(us(1000 * interval));
    if (interval == 0) line.send(frame("102#"));
    const auto received = run_until(line, us(1000 * interval + 1000));
    EXPECT_EQ(received.size(), interval == 0 ? 1u : 0u);
  }
  EXPECT_EQ(node.syncs, (std::vector<Time>{us(0), us(2000)}));
}

TEST(Faults, WrongAnswersNameAnotherParameterAndOffset) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1)
      .expect("501#70FF0000")
      .reply("581#00FF12340000")  // parameter 0x0FF
      .expect("501#E006")
      .reply("581#8006AABBCCDDEEFF")  // upload block at offset 6
      .expect("501#70FF0000")
      .reply("581#00FF12340000");
  Line line({.faults = {{.kind = FaultKind::wrong_answer, .count = 2, .node = 1}},
             .protocol = &sim::drive_faults()},
            std::move(nodes));
  line.send(frame("501#70FF0000"));
  EXPECT_EQ(texts(run_until(line, us(500))).back(), "581#010012340000");
  line.send(frame("501#E006"));
  EXPECT_EQ(texts(run_until(line, us(1000))).back(), "581#800CAABBCCDDEEFF");
  line.send(frame("501#70FF0000"));
  EXPECT_EQ(texts(run_until(line, us(1500))).back(), "581#00FF12340000");
  EXPECT_EQ(line.faults().hits(0), 2u);
}

TEST(Faults, BusyAnswersCarryNothing) {
  Nodes nodes;
  add<ScriptedNode>(nodes, 1)
      .expect("501#70FF0000")
      .reply("581#20FFFFFF0000")  // an error
      .expect("501#E006")
      .reply("581#8006AABBCCDDEEFF")
      .expect("101#")
      .reply("301#0001");
  Line line({.faults = {{.kind = FaultKind::busy}}, .protocol = &sim::drive_faults()}, std::move(nodes));
  line.send(frame("501#70FF0000"));
  EXPECT_EQ(texts(run_until(line, us(500))).back(), "581#40FF");
  line.send(frame("501#E006"));
  EXPECT_EQ(texts(run_until(line, us(1000))).back(), "581#C006");
  line.send(frame("101#"));
  EXPECT_EQ(texts(run_until(line, us(1500))).back(), "301#0001") << "no response, so not touched";
  EXPECT_EQ(line.faults().hits(0), 2u);
}

TEST(Faults, MissingSyncForOneSlaveOrForAll) {
  RecordingTrace trace;
  Nodes nodes;
  auto& first = add<ListeningNode>(nodes, 1);
  auto& second = add<ListeningNode>(nodes, 2);
  Line line({.faults = {{.kind = FaultKind::missing_sync, .from = 1, .count = 1, .node = 1},
                        {.kind = FaultKind::missing_sync, .from = 3, .to = 4}},
             .trace = &trace},
            std::move(nodes));
  for (int interval = 0; interval < 6; ++interval) {
    line.sync_edge(us(1000 * interval));
    run_until(line, us(1000 * interval + 1000));
  }
  EXPECT_EQ(first.syncs, (std::vector<Time>{us(0), us(2000), us(5000)}));
  EXPECT_EQ(second.syncs, (std::vector<Time>{us(0), us(1000), us(2000), us(5000)}));
  EXPECT_EQ(trace.syncs, second.syncs) << "an edge for nobody is not on the wire";
  EXPECT_EQ(line.faults().hits(0), 1u);
  EXPECT_EQ(line.faults().hits(1), 2u);
}

TEST(Faults, InjectedFrameComesAtItsTime) {
  RecordingTrace trace;
  Nodes nodes;
  auto& node = add<ListeningNode>(nodes, 1);
  Line line(
      {.faults =
           {{.kind = FaultKind::inject, .from = 1, .count = 2, .delay = us(250), .frame = frame("17F#1122")}},
       .trace = &trace},
      std::move(nodes));
  for (int interval = 0; interval < 4; ++interval) {
    line.sync_edge(us(1000 * interval));
    run_until(line, us(1000 * interval + 1000));
  }
  EXPECT_EQ(heard(node), (Texts{"17F#1122", "17F#1122"}));
  ASSERT_EQ(trace.frames.size(), 2u);
  EXPECT_EQ(trace.frames[0].start, us(1250));
  EXPECT_EQ(trace.frames[1].start, us(2250));
  EXPECT_EQ(trace.frames[0].sender.kind, sim::Sender::Kind::foreign);
}

}  // namespace
