// What the simulated drives do with the frames of a bus that is not simulated.

#include "simulator/bench.h"

#include <gtest/gtest.h>

#include "can/frame_length.h"
#include "rig.h"

namespace {

using namespace std::chrono_literals;
using cansync_sim::Bench;

/// Gives a bench frames at instants and collects what it wants to send.
class BenchTest : public testing::Test {
 protected:
  void use(const std::vector<unsigned>& numbers, std::vector<sim::Fault> faults = {}) {
    bench_ = std::make_unique<Bench>(bench_settings(std::move(faults)), drives(numbers));
  }

  std::vector<std::string> give(const std::string& what, can::Time at, can::Time seen = can::Time{0}) {
    const can::Time now = std::max(at, seen);
    bench_->receive({frame(what), at, false}, now);
    return due(now);
  }

  std::vector<std::string> due(can::Time now) {
    std::vector<std::string> out;
    while (const auto next = bench_->next(now)) {
      out.push_back(frame_text(*next));
      bench_->sent(can::SendResult::queued);
    }
    return out;
  }

  std::unique_ptr<Bench> bench_;
};

using Texts = std::vector<std::string>;

// The SYNC edge is the frame's first bit; frames are given by the end of their last one. 2 us a bit.
can::Time sync_frame() {
  return (can::frame_bits(frame("080#")) - can::kInterframeBits) * can::Time(2us);
}

TEST_F(BenchTest, AnswersAParameterReadOfEachDrive) {
  use({3, 5});
  give("080#", 0ms);
  // Parameter 103, the slave number: 0x70 | bits 11..8, then 0x67; the answer is a word.
  EXPECT_EQ(give("503#70670000", 1ms), Texts{"583#006703000000"});
  EXPECT_EQ(give("505#70670000", 1ms), Texts{"585#006705000000"});
  EXPECT_EQ(give("504#70670000", 1ms), Texts{}) << "no drive has this number";
}

TEST_F(BenchTest, SendsActualValuesWhenTheSyncFrameHasCome) {
  use({1});
  EXPECT_EQ(give("101#0000000000000000", 1ms), Texts{}) << "nothing is released before the first SYNC";
  give("080#", 2ms);
  EXPECT_EQ(give("101#0000000000000000", 2500us).size(), 1u);
  EXPECT_EQ(give("101#0000000000000000", 2500us), Texts{}) << "one release is good for one telegram";
  give("080#", 4ms);
  const Texts second = give("181#0000000000000000", 4500us);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(second[0].substr(0, 4), "381#");
  EXPECT_EQ(bench_->counters().syncs, 2u);
}

TEST_F(BenchTest, LeavesOutActualValuesAfterTheirSlot) {
  use({1});
  give("080#", 0ms);
  // tRDC1 is 1060 us at 500 kbit/s.
  EXPECT_EQ(give("101#0000000000000000", 1060us + 1ns - sync_frame()), Texts{});
  give("080#", 2ms);
  EXPECT_EQ(give("101#0000000000000000", 3060us - sync_frame()).size(), 1u);
}

TEST_F(BenchTest, TakesTheInstantOfTheFrameNotOfTheLook) {
  use({1});
  give("080#", 0ms, 500us);
  EXPECT_EQ(give("101#0000000000000000", 700us, 1500us).size(), 1u);
}

TEST_F(BenchTest, DropsAnswersNobodyWaitsForAnyMore) {
  use({1});
  give("080#", 0ms);
  EXPECT_EQ(give("501#70670000", 1ms, 3001us), Texts{});
  EXPECT_EQ(bench_->counters().too_late, 1u);
}

TEST_F(BenchTest, OtherIdentifiersAreNoSync) {
  use({1});
  give("081#", 0ms);
  give("00000080#", 0ms);
  give("080#R", 0ms);
  give("080#00", 0ms);
  EXPECT_EQ(bench_->counters().syncs, 0u);
  EXPECT_EQ(bench_->counters().received, 4u);
}

TEST_F(BenchTest, LocksByActivationAndSync) {
  use({1});
  give("010#FFFFFFFF02010000", 0ms);
  for (int interval = 0; interval <= 6; ++interval) give("080#", interval * 2ms);
  EXPECT_NE(bench_->drives()[0]->status_word() & sim::status_bit::synchronized, 0);
}

sim::Fault fault(sim::FaultKind kind, sim::NodeNumber slave) {
  sim::Fault out;
  out.kind = kind;
  out.node = slave;
  return out;
}

TEST_F(BenchTest, ASilentDriveIsSilentInItsIntervals) {
  sim::Fault silent = fault(sim::FaultKind::silent, 1);
  silent.from = 1;
  silent.to = 1;
  use({1, 2}, {silent});
  give("080#", 0ms);
  EXPECT_EQ(give("501#70670000", 1ms).size(), 1u);
  give("080#", 2ms);
  EXPECT_EQ(give("501#70670000", 3ms).size(), 0u);
  EXPECT_EQ(give("502#70670000", 3ms).size(), 1u);
  give("080#", 4ms);
  EXPECT_EQ(give("501#70670000", 5ms).size(), 1u);
}

TEST_F(BenchTest, ALostAnswerIsNotSentAndALostCommandNotHeard) {
  sim::Fault answer = fault(sim::FaultKind::lost, 1);
  answer.identifier = 0x580;
  answer.mask = 0x780;
  answer.count = 1;
  sim::Fault command = answer;
  command.identifier = 0x500;
  command.from = 1;
  use({1}, {answer, command});
  give("080#", 0ms);
  EXPECT_EQ(give("501#70670000", 1ms), Texts{});
  EXPECT_EQ(give("501#70670000", 1ms).size(), 1u);
  give("080#", 2ms);
  EXPECT_EQ(give("501#70670000", 3ms), Texts{});
  EXPECT_EQ(give("501#70670000", 3ms).size(), 1u);
}

TEST_F(BenchTest, ALateAnswerWaits) {
  sim::Fault late = fault(sim::FaultKind::late, 1);
  late.delay = 300us;
  use({1}, {late});
  give("080#", 0ms);
  EXPECT_EQ(give("501#70670000", 1ms), Texts{});
  EXPECT_EQ(bench_->next_due(), can::Time(1300us));
  EXPECT_EQ(due(1299us), Texts{});
  EXPECT_EQ(due(1300us), Texts{"581#006701000000"});
  EXPECT_EQ(bench_->next_due(), can::Time::max());
}

TEST_F(BenchTest, ADuplicatedAnswerIsSentTwice) {
  use({1}, {fault(sim::FaultKind::duplicated, 1)});
  give("080#", 0ms);
  // The command comes twice as well, and each answer goes out twice.
  EXPECT_EQ(give("501#70670000", 1ms).size(), 4u);
}

TEST_F(BenchTest, WrongAndBusyAnswers) {
  sim::Fault wrong = fault(sim::FaultKind::wrong_answer, 1);
  wrong.to = 0;
  sim::Fault busy = fault(sim::FaultKind::busy, 1);
  busy.from = 1;
  use({1}, {wrong, busy});
  give("080#", 0ms);
  EXPECT_EQ(give("501#70670000", 1ms), Texts{"581#006801000000"});
  give("080#", 2ms);
  const Texts answer = give("501#70670000", 3ms);
  ASSERT_EQ(answer.size(), 1u);
  EXPECT_EQ(answer[0].substr(0, 8), "581#4067");
}

TEST_F(BenchTest, AMissingSyncReleasesNothing) {
  sim::Fault missing = fault(sim::FaultKind::missing_sync, 1);
  missing.from = 1;
  use({1, 2}, {missing});
  give("080#", 0ms);
  EXPECT_EQ(give("101#0000000000000000", 500us).size(), 1u);
  give("080#", 2ms);
  EXPECT_EQ(give("101#0000000000000000", 2500us).size(), 0u);
  EXPECT_EQ(give("102#0000000000000000", 2600us).size(), 1u);
}

TEST_F(BenchTest, InjectsForeignFramesAfterSync) {
  sim::Fault inject;
  inject.kind = sim::FaultKind::inject;
  inject.frame = frame("17F#AA");
  inject.delay = 400us;
  inject.from = 1;
  inject.to = 1;
  use({1}, {inject});
  EXPECT_EQ(give("080#", 0ms), Texts{});
  EXPECT_EQ(due(1ms), Texts{});
  give("080#", 2ms);
  EXPECT_EQ(due(2400us - 1ns - sync_frame()), Texts{});
  EXPECT_EQ(due(2400us - sync_frame()), Texts{"17F#AA"});
}

TEST_F(BenchTest, NothingWaitsAfterTheLinkWasLost) {
  sim::Fault late = fault(sim::FaultKind::late, 1);
  late.delay = 300us;
  use({1}, {late});
  give("080#", 0ms);
  give("501#70670000", 1ms);
  bench_->link_lost();
  EXPECT_EQ(due(2ms), Texts{});
}

TEST_F(BenchTest, GarbageChangesNothing) {
  use({1});
  for (const char* garbage : {"501#", "501#70", "501#706700", "101#00", "010#00", "581#0067", "301#",
                              "7FF#0102030405060708", "1FFFFFFF#00", "501#R"}) {
    EXPECT_EQ(give(garbage, 0ms), Texts{}) << garbage;
  }
  can::Frame error;
  error.error = true;
  bench_->receive({error, 0ms, false}, 0ms);
  EXPECT_EQ(bench_->counters().error_frames, 1u);
  give("080#", 2ms);
  EXPECT_EQ(give("501#70670000", 3ms).size(), 1u);
}

}  // namespace
