// The slave's realtime machine on a simulated line, in virtual time.
#include "daemon/cansync_slave/realtime/slave_machine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "slave_rig.h"

namespace cansyncd {
namespace {

using namespace test;
using std::chrono::microseconds;

class SlaveAtEveryRate : public testing::TestWithParam<cansync::BitRate> {};

TEST_P(SlaveAtEveryRate, LocksIsActivatedAndTakesReferenceValues) {
  SlaveRig rig(GetParam());
  rig.run_until(2000 * rig.times.interval);
  EXPECT_TRUE(rig.snapshot.synchronized);
  EXPECT_EQ(rig.snapshot.status_word, 0x8000);
  EXPECT_EQ(rig.master->master().state(), cansync::State::active_master);
  EXPECT_EQ(rig.snapshot.missing_edges, 0u);
  EXPECT_EQ(rig.snapshot.responses.late, 0u);
  const auto references = rig.told<ReferencesReport>();
  ASSERT_GT(references.size(), 1000u);
  // The ramp rises by one an interval; WRC1 and WRC2 come in turns.
  for (std::size_t i = 2; i < references.size(); ++i) {
    EXPECT_EQ(references[i].values.arrived, 3 - references[i - 1].values.arrived);
    EXPECT_EQ(references[i].values.values[4], 44u);
    if (references[i].values.arrived != 1) continue;
    EXPECT_EQ(references[i].values.values[0], references[i - 2].values.values[0] + 1);
    EXPECT_EQ(references[i].values.interval[0], references[i - 2].values.interval[0] + 1);
  }
  ASSERT_FALSE(rig.actions.empty());
  EXPECT_EQ(rig.actions[0].kind, SlaveAction::sync_mode);
  EXPECT_EQ(rig.actions[0].number, 1u);
}

TEST_P(SlaveAtEveryRate, AskedAndNotReleasedIsNoTelegram) {
  SlaveRig rig(GetParam());
  rig.run_until(1500 * rig.times.interval);
  EXPECT_GT(rig.snapshot.actual[0].asked, 100u);
  EXPECT_EQ(rig.snapshot.actual[0].not_released, rig.snapshot.actual[0].asked);
  EXPECT_TRUE(rig.trace.starts(cansync::identifier::actual_one + kNumber).empty());
  EXPECT_TRUE(rig.trace.starts(cansync::identifier::actual_two + kNumber).empty());
}

TEST_P(SlaveAtEveryRate, ResponsesStartInTheirSlot) {
  SlaveRig rig(GetParam());
  rig.run_until(1500 * rig.times.interval);
  const auto starts = rig.trace.starts(cansync::identifier::response + kNumber);
  ASSERT_GT(starts.size(), 1u);
  EXPECT_GT(rig.snapshot.responses.sent, 1u);
  // Once the intervals have process data: by tRC.
  EXPECT_LE(starts.back(), rig.times.response);
}

INSTANTIATE_TEST_SUITE_P(Rates, SlaveAtEveryRate,
                         testing::Values(cansync::BitRate::kbit125, cansync::BitRate::kbit250,
                                         cansync::BitRate::kbit500, cansync::BitRate::mbit1));

/// Releases telegram `channel` at an instant.
void release_at(SlaveRig& rig, can::Time when, cansync::Channel channel, std::uint32_t value,
                std::uint32_t intervals) {
  rig.at(when, [&rig, channel, value, intervals] {
    ASSERT_TRUE(rig.exchange.releases.try_push({channel, {value, value + 1, 0, 0}, 0x03, intervals}));
  });
}

constexpr std::uint32_t kActualOne = cansync::identifier::actual_one + kNumber;
constexpr std::uint32_t kActualTwo = cansync::identifier::actual_two + kNumber;

TEST_P(SlaveAtEveryRate, EachReleaseIsSentOnceAndInItsSlot) {
  SlaveRig rig(GetParam());
  const can::Time interval = rig.times.interval;
  for (unsigned i = 0; i < 50; ++i) {
    release_at(rig, (1500 + 10 * i) * interval, cansync::Channel::one, 1000 + i, 5);
    release_at(rig, (1500 + 10 * i) * interval, cansync::Channel::two, 2000 + i, 5);
  }
  rig.run_until(2100 * interval);
  const auto one = rig.trace.starts(kActualOne);
  const auto two = rig.trace.starts(kActualTwo);
  EXPECT_EQ(one.size(), 50u);
  EXPECT_EQ(two.size(), 50u);
  for (const can::Time start : one) EXPECT_LE(start, rig.times.actual_one);
  for (const can::Time start : two) EXPECT_LE(start, rig.times.actual_two);
  for (const unsigned channel : {0u, 1u}) {
    EXPECT_EQ(rig.snapshot.released[channel], 50u);
    EXPECT_EQ(rig.snapshot.unused[channel], 0u);
    EXPECT_EQ(rig.snapshot.actual[channel].sent, 50u);
    EXPECT_EQ(rig.snapshot.actual[channel].late, 0u);
  }
  EXPECT_EQ(rig.snapshot.answers.failed, 0u);
}

TEST(SlaveMachineTest, ReleasedAndNotAskedIsNoTelegram) {
  SlaveRig rig;
  const can::Time interval = rig.times.interval;
  rig.at(1490 * interval, [&rig] {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}}) rig.master->set_reference(value, {});
  });
  release_at(rig, 1500 * interval, cansync::Channel::one, 7, 3);
  rig.at(1550 * interval,
         [&rig] { rig.master->set_reference(0, {.kind = sim::ReferenceCurve::Kind::constant}); });
  rig.run_until(1600 * interval);
  EXPECT_EQ(rig.snapshot.unused[0], 1u);
  EXPECT_TRUE(rig.trace.starts(kActualOne).empty());
}

TEST(SlaveMachineTest, ANewerReleaseReplacesAndAWithdrawalEndsIt) {
  SlaveRig rig;
  const can::Time interval = rig.times.interval;
  rig.at(1490 * interval, [&rig] { rig.master->set_reference(0, {}); });
  release_at(rig, 1500 * interval, cansync::Channel::one, 7, 900);
  release_at(rig, 1502 * interval, cansync::Channel::one, 8, 900);
  release_at(rig, 1504 * interval, cansync::Channel::one, 0, 0);
  rig.at(1550 * interval,
         [&rig] { rig.master->set_reference(0, {.kind = sim::ReferenceCurve::Kind::constant}); });
  rig.run_until(1600 * interval);
  EXPECT_EQ(rig.snapshot.unused[0], 2u);
  EXPECT_TRUE(rig.trace.starts(kActualOne).empty());
}

TEST(SlaveMachineTest, AReleaseThatWouldStartAfterItsSlotIsNeverSent) {
  SlaveRig rig;
  const can::Time interval = rig.times.interval;
  rig.at(1500 * interval, [&rig] { rig.bus->late = microseconds(300); });
  release_at(rig, 1510 * interval, cansync::Channel::one, 7, 900);
  rig.run_until(1600 * interval);
  EXPECT_EQ(rig.snapshot.actual[0].late, 1u);
  EXPECT_EQ(rig.snapshot.actual[0].sent, 0u);
  EXPECT_TRUE(rig.trace.starts(kActualOne).empty());
}

/// A master that starts anew, and whose SYNC does not reach the slave any more, is answered as on any line
/// that is set up.
TEST(SlaveMachineTest, WithoutEdgesAndReferenceValuesCommandsAreAnsweredWithinTheirTime) {
  SlaveRig rig(cansync::BitRate::mbit1, {missing_edges(1500, 2000)});
  rig.at(1700 * rig.times.interval, [&rig] {
    using cansync::ControlCommand;
    for (const ControlCommand command :
         {ControlCommand::cold_restart, ControlCommand::handshake, ControlCommand::take_over_initialisation,
          ControlCommand::start_synchronous})
      ASSERT_EQ(rig.master->master().control(command), cansync::Refusal::none);
  });
  rig.run_until(2000 * rig.times.interval);
  EXPECT_EQ(rig.snapshot.sync.state, sync_line::LockState::lost);
  can::Time asked{};
  unsigned answers = 0;
  for (const sim::TracedFrame& one : rig.trace.frames) {
    if (one.frame.identifier() == cansync::identifier::command + kNumber) asked = one.end;
    if (one.frame.identifier() != cansync::identifier::response + kNumber) continue;
    if (one.start < 1710 * rig.times.interval) continue;
    ++answers;
    ASSERT_LE(one.start - asked, rig.times.response_timeout);
  }
  EXPECT_GT(answers, 10u);
  EXPECT_EQ(rig.snapshot.responses.late, 0u);
}

/// Before the intervals follow the input, too: an edge that came while the thread stood still is not the one
/// that the command came after.
TEST(SlaveMachineTest, AThreadThatWakesLateBeforeItIsTimedAnswersNoCommandAfterItsSlot) {
  for (can::Time late = microseconds(100); late < microseconds(1000); late += microseconds(50)) {
    SlaveRig rig(cansync::BitRate::mbit1, {}, microseconds(400));
    rig.bus->late = late;
    rig.run_until(350 * rig.times.interval);
    EXPECT_EQ(rig.snapshot.sync.state, sync_line::LockState::searching);
    EXPECT_GT(rig.snapshot.responses.asked, 0u);
    can::Time asked{};
    for (const sim::TracedFrame& one : rig.trace.frames) {
      if (one.frame.identifier() == cansync::identifier::command + kNumber) asked = one.start;
      if (one.frame.identifier() != cansync::identifier::response + kNumber) continue;
      const auto after = std::upper_bound(rig.trace.edges.begin(), rig.trace.edges.end(), asked);
      ASSERT_NE(after, rig.trace.edges.begin());
      ASSERT_LE(one.start - *(after - 1), rig.times.command) << late.count() << " ns late";
    }
  }
}

TEST(SlaveMachineTest, AThreadThatWakesLateAnswersNoCommandAfterItsSlot) {
  SlaveRig rig;
  rig.at(1500 * rig.times.interval, [&rig] { rig.bus->late = microseconds(700); });
  rig.run_until(2500 * rig.times.interval);
  EXPECT_GT(rig.snapshot.responses.late, 0u);
  for (const can::Time start : rig.trace.starts(cansync::identifier::response + kNumber))
    EXPECT_LE(start, rig.times.command);
}

/// Asks the slave for a parameter.
void ask_at(SlaveRig& rig, can::Time when, unsigned number) {
  rig.at(when, [&rig, number] {
    cansync::ParameterRequest request;
    request.id = number;
    request.slave = *cansync::SlaveNumber::from(kNumber);
    request.number = *cansync::ParameterNumber::from(number);
    ASSERT_EQ(rig.master->master().submit(request), cansync::Refusal::none);
  });
}

/// An answer that waits for its slot when the slave is stopped: its asker is told "dropped".
TEST(SlaveMachineTest, NothingIsAnsweredAfterAStop) {
  constexpr unsigned kSteps = 32;
  for (unsigned step = 0; step < kSteps; ++step) {
    SlaveRig rig;
    const can::Time interval = rig.times.interval;
    ask_at(rig, 1500 * interval, 301);
    const can::Time stop = 1501 * interval + step * interval / (kSteps / 2);
    rig.at(stop,
           [&rig] { ASSERT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{.mode = SlaveMode::stop})); });
    rig.run_until(1520 * interval);
    // What was handed over may wait for the frame that is on the bus.
    const can::Time last = stop + microseconds(150);
    for (const sim::TracedFrame& one : rig.trace.frames) {
      if (one.frame.identifier() != cansync::identifier::response + kNumber) continue;
      EXPECT_LE(one.start, last) << "stopped in step " << step;
    }
  }
}

void take_over_at(SlaveRig& rig, can::Time when, unsigned number) {
  rig.at(when, [&rig, number] {
    TakeOver order;
    order.present = true;
    order.taken.numbers.set(number);
    ASSERT_TRUE(rig.exchange.orders.try_push(order));
  });
}

std::vector<JobReport> job_reports(SlaveRig& rig) {
  std::vector<JobReport> found;
  ServiceReport report;
  while (rig.exchange.jobs.try_pop(report)) found.push_back(std::get<JobReport>(report));
  return found;
}

TEST(SlaveMachineTest, ThatAJobIsAnsweredHasTheTimeAtWhichItsAnswerWasOnTheBus) {
  SlaveRig rig;
  const can::Time interval = rig.times.interval;
  take_over_at(rig, 1490 * interval, 500);
  ask_at(rig, 1500 * interval, 500);
  rig.at(1520 * interval, [&rig] {
    const auto asked = job_reports(rig);
    ASSERT_EQ(asked.size(), 1u);
    ASSERT_TRUE(rig.exchange.orders.try_push(JobAnswer{asked[0].job.id, {.value = 7}}));
  });
  rig.run_until(1600 * interval);
  const auto ended = job_reports(rig);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].step, JobReport::Step::answered);
  can::Time end{};
  for (const sim::TracedFrame& one : rig.trace.frames) {
    const bool ours = one.frame.identifier() == cansync::identifier::response + kNumber;
    if (ours && one.frame.data[0] == 0x01 && one.frame.data[1] == 0xF4) end = one.end;  // 500, not busy
  }
  EXPECT_EQ(ended[0].when.bus, end);
}

TEST(SlaveMachineTest, NoApplicationTakesTheStatusWordOver) {
  SlaveRig rig;
  const can::Time interval = rig.times.interval;
  take_over_at(rig, 1490 * interval, 301);
  ask_at(rig, 1500 * interval, 301);
  rig.run_until(1600 * interval);
  EXPECT_TRUE(job_reports(rig).empty());
  EXPECT_TRUE(rig.snapshot.synchronized);
}

}  // namespace
}  // namespace cansyncd
