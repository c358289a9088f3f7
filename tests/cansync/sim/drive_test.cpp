#include "cansync/sim/drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "drive_rig.h"

// The drive on the bus: what it accepts, when it answers, how it locks on SYNC and loses it.
namespace sim {
namespace {

using cansync::BitRate;
using cansync::Channel;
using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST(Drive, AcceptsReferencesActionsItsOwnCommandsAndMonitoredSlavesAlone) {
  DriveSettings settings = rig_settings();
  settings.slave.monitored[7] =
      cansync::ProcessMapping{default_mapping(Channel::one), default_mapping(Channel::two)};
  const Drive drive(settings);
  std::set<std::uint32_t> accepted;
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    if (drive.accepts({.id = id})) accepted.insert(id);
    EXPECT_FALSE(drive.accepts({.id = id, .extended = true})) << id;
    EXPECT_FALSE(drive.accepts({.id = id, .remote = true})) << id;
  }
  std::set<std::uint32_t> wanted = {0x010, 0x503, 0x307, 0x387};
  for (std::uint32_t id = 0x100; id <= 0x1FF; ++id) wanted.insert(id);
  EXPECT_EQ(accepted, wanted);
}

TEST(Drive, ServesProcessDataByItself) {
  DriveRig rig;
  EXPECT_EQ(rig.drive.slave().state(), cansync::State::active_slave);
  EXPECT_FALSE(rig.reference(1, 0, Channel::one, kRigNumber)) << "actual values are released at an edge";
  rig.edge();
  const auto answer = rig.reference(1, 0, Channel::one, kRigNumber);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->frame.id, 0x303u);
  EXPECT_EQ(answer->frame.dlc, 8);
  EXPECT_FALSE(rig.reference(1, 0, Channel::one, kRigNumber + 1));
}

TEST(Drive, IgnoresFramesThatAreNoTelegrams) {
  DriveRig rig;
  EXPECT_FALSE(rig.drive.on_frame({}, rig.now));
}

TEST(Drive, DefaultMappingCarriesPositionSpeedTorqueAndStatus) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 200; ++i) rig.follow(i * 1000);
  const auto one = rig.reference(200'000, 0, Channel::one, kRigNumber);
  const auto two = rig.reference(77, 0, Channel::two, kRigNumber);
  ASSERT_TRUE(one && two);
  const auto& first = one->frame.data;
  const auto& second = two->frame.data;
  EXPECT_EQ(cansync::load_doubleword(first.data()), rig.drive.actual()[0]);
  EXPECT_NEAR(rig.speed(), 1'000'000, 100);
  EXPECT_EQ(cansync::load_doubleword(first.data() + 4), rig.drive.actual()[1]);
  EXPECT_GT(rig.actual(4), 0);
  EXPECT_EQ(cansync::load_doubleword(second.data()), rig.drive.actual()[4]);
  EXPECT_EQ(cansync::load_word(second.data() + 4), rig.drive.status_word());
  EXPECT_EQ(cansync::load_word(second.data() + 6), 0) << "fault code";
  rig.edge();
  EXPECT_EQ(rig.actual(7), 77) << "reference value 4 comes back";
}

// --- timing

class EveryBitRate : public ::testing::TestWithParam<BitRate> {};

TEST_P(EveryBitRate, AnswersMeetTheirSlotsWithWorstCaseTelegrams) {
  DriveSettings settings = rig_settings();
  settings.slave.bit_rate = GetParam();
  DriveRig rig(settings);
  rig.lock();
  const cansync::Duration longest = rig.times.bit_time() * 135;
  const cansync::Duration margin = microseconds(50);
  const auto answer_to = [&](const cansync::Telegram& telegram, cansync::Duration latest_start) {
    const auto answer = rig.send(telegram, latest_start - margin + longest);
    return answer ? std::optional(answer->not_before - rig.now) : std::nullopt;
  };
  cansync::ReferenceTelegram telegram;
  telegram.polled = kRigNumber;
  const auto one = answer_to(telegram, rig.times.reference_one);
  telegram.channel = Channel::two;
  const auto two = answer_to(telegram, rig.times.reference_two);
  const auto response = answer_to(rig.read(parameter::status_word), rig.times.command);
  ASSERT_TRUE(one && two && response);
  EXPECT_LE(*one, rig.times.actual_one);
  EXPECT_LE(*two, rig.times.actual_two);
  EXPECT_LE(*response - rig.times.interval, rig.times.response);
  // One telegram at a time: RDC1 is over when WRC2 may start.
  EXPECT_LE(*one + longest, rig.times.reference_two);
  EXPECT_EQ(rig.drive.left_out(), 0u);
}

TEST_P(EveryBitRate, LeavesOutActualValuesThatWouldMissTheirSlot) {
  DriveSettings settings = rig_settings();
  settings.slave.bit_rate = GetParam();
  DriveRig rig(settings);
  rig.edge();
  cansync::ReferenceTelegram telegram;
  telegram.polled = kRigNumber;
  const cansync::Duration delay = rig.times.bit_time() * 20;
  EXPECT_FALSE(rig.send(telegram, rig.times.actual_one - delay + microseconds(1)));
  EXPECT_EQ(rig.drive.left_out(), 1u);
  rig.edge();
  EXPECT_TRUE(rig.send(telegram, rig.times.actual_one - delay));
  EXPECT_EQ(rig.drive.left_out(), 1u);
}

/// However late the command, its answer is in the slot of this interval or of the next (M 3.1.1.1).
TEST_P(EveryBitRate, AnswersACommandThatEndsJustBeforeTheEndOfItsSlot) {
  DriveSettings settings = rig_settings();
  settings.slave.bit_rate = GetParam();
  DriveRig rig(settings);
  rig.edge();
  const cansync::Duration delay = rig.times.bit_time() * 20;
  const cansync::Duration until = rig.times.command - rig.times.response_timeout;
  for (const cansync::Duration around : {until - delay, rig.times.command - delay}) {
    for (cansync::Duration end = around - delay; end <= around + delay; end += microseconds(1)) {
      const auto answer = rig.send(rig.read(parameter::status_word), end);
      ASSERT_TRUE(answer) << end.count();
      const cansync::Duration start = answer->not_before - rig.now;
      EXPECT_EQ(start, (end + delay <= until ? end : rig.times.interval) + delay) << end.count();
    }
  }
  EXPECT_EQ(rig.drive.left_out(), 0u);
}

TEST_P(EveryBitRate, LocksAfterTheLockTime) {
  DriveSettings settings = rig_settings();
  settings.slave.bit_rate = GetParam();
  settings.lock_time = milliseconds(80);
  DriveRig rig(settings);
  rig.edges(1000);
  EXPECT_FALSE(rig.synchronized()) << "not before the action \"SYNC mode: activate\"";
  rig.activate();
  const auto edges = static_cast<unsigned>(settings.lock_time / rig.times.interval);
  rig.edges(edges);
  EXPECT_FALSE(rig.synchronized());
  rig.edge();
  EXPECT_TRUE(rig.synchronized());
}

INSTANTIATE_TEST_SUITE_P(Drive, EveryBitRate,
                         ::testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                           BitRate::mbit1),
                         [](const auto& instance) {
                           return std::to_string(cansync::slot_times(instance.param).bits_per_second);
                         });

TEST(Drive, ProcessingDelayIsSettable) {
  DriveSettings settings = rig_settings();
  settings.processing_delay = microseconds(37);
  DriveRig rig(settings);
  rig.edge();
  const auto answer = rig.reference(0, 0, Channel::one, kRigNumber);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->not_before, rig.now + microseconds(100 + 37));
}

// --- SYNC

TEST(DriveSyncLoss, OneMissingEdgeIsRiddenThrough) {
  DriveRig rig;
  rig.lock();
  rig.edge(1);
  EXPECT_TRUE(rig.synchronized());
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
}

TEST(DriveSyncLoss, TooManyMissingEdgesLoseTheLockAndFault) {
  DriveSettings settings = rig_settings();
  settings.edges_until_fault = 4;
  DriveRig rig(settings);
  rig.lock();
  rig.edge(3);
  EXPECT_TRUE(rig.synchronized());
  rig.edge(4);
  EXPECT_FALSE(rig.synchronized());
  EXPECT_TRUE(rig.has(status_bit::fault));
  EXPECT_EQ(rig.drive.fault(), fault_code::sync_lost);
  rig.edges(600);
  EXPECT_TRUE(rig.synchronized()) << "locks again by itself";
  EXPECT_EQ(rig.drive.fault(), fault_code::sync_lost) << "but the fault waits for its reset";
  rig.control(control_bit::run | control_bit::fault_reset);
  EXPECT_FALSE(rig.has(status_bit::fault));
}

TEST(DriveSyncLoss, ActivationAcknowledgesCommunicationFaultsOnly) {
  DriveRig rig;
  rig.lock();
  rig.edge(20);
  EXPECT_EQ(rig.drive.fault(), fault_code::sync_lost);
  rig.activate();
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  rig.drive.raise_fault(99);
  rig.activate();
  EXPECT_EQ(rig.drive.fault(), 99);
}

TEST(DriveSyncLoss, StatusWordReadTellsOfSilenceBeforeTheNextEdge) {
  DriveRig rig;
  rig.lock();
  const cansync::ParameterCommand read = rig.read(parameter::status_word);
  const auto status = [&](cansync::Duration after) {
    return cansync::load_word(rig.send(read, after)->frame.data.data() + 2);
  };
  EXPECT_TRUE(status(milliseconds(10)) & status_bit::synchronized);
  const auto silent = status(milliseconds(50));
  EXPECT_FALSE(silent & status_bit::synchronized);
  EXPECT_TRUE(silent & status_bit::fault);
}

TEST(DriveSyncLoss, SilenceWhileLockingStartsTheLockTimeAgainWithoutAFault) {
  DriveRig rig;
  rig.edge();
  rig.activate();
  rig.edges(400);
  rig.edge(30);
  rig.edges(400);
  EXPECT_FALSE(rig.synchronized());
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  rig.edges(101);
  EXPECT_TRUE(rig.synchronized());
}

TEST(DriveSyncLoss, EdgesOutOfTurnNeitherMoveNorCount) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 50; ++i) rig.follow(i * 100);
  const std::int32_t before = rig.position();
  rig.drive.on_sync(rig.now + microseconds(200));
  EXPECT_EQ(rig.position(), before);
  EXPECT_TRUE(rig.synchronized());
}

// --- whole drives

TEST(Drive, RestartIsLikePowerOffAndOn) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 100; ++i) rig.follow(i * 100);
  ASSERT_TRUE(rig.drive.set_parameter(parameter::first_plain_word, 5));
  rig.drive.memory().contents()[0] = 9;
  rig.drive.raise_fault(50);
  rig.drive.restart();
  EXPECT_FALSE(rig.synchronized());
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  EXPECT_EQ(rig.drive.motion().position(), 0);
  EXPECT_EQ(rig.drive.parameters().value(parameter::first_plain_word), 0u);
  EXPECT_EQ(rig.drive.memory().contents()[0], 9) << "memory keeps its contents";
  rig.lock();
}

TEST(Drive, SameInputsGiveTheSameActualValues) {
  DriveRig first;
  DriveRig second;
  first.lock();
  second.lock();
  std::uint32_t seed = 12345;
  for (int i = 0; i < 2000; ++i) {
    seed = seed * 1664525u + 1013904223u;
    const auto reference = static_cast<std::int32_t>(seed >> 8);
    for (DriveRig* rig : {&first, &second}) {
      if (seed % 7 != 0) rig->reference(reference);
      if (seed % 97 == 0) rig->control(control_bit::enable | control_bit::fault_reset);
      if (seed % 89 == 0) rig->control(control_bit::run | control_bit::fault_reset);
      rig->edge();
    }
    ASSERT_EQ(first.drive.actual(), second.drive.actual());
  }
}

TEST(Drive, FollowsAnotherSlaveThatItMonitors) {
  DriveSettings settings = rig_settings();
  settings.axis.leader = cansync::SlaveNumber::from(9);
  settings.misses_until_fault = 0;
  DriveRig rig(settings);
  EXPECT_TRUE(rig.drive.accepts({.id = 0x309}));
  rig.lock();
  cansync::ActualTelegram telegram;
  telegram.slave = *cansync::SlaveNumber::from(9);
  // The leader moves 100 increments an interval and is asked every 16th.
  for (unsigned i = 0; i < 640; ++i) {
    if (i % 16 == 0) {
      telegram.word[0] = static_cast<std::uint16_t>((i * 100) & 0xFFFF);
      telegram.word[1] = static_cast<std::uint16_t>((i * 100) >> 16);
      rig.send(telegram);
    }
    rig.edge();
  }
  EXPECT_NEAR(rig.speed(), 100'000, 100) << "carried on evenly between two telegrams";
  EXPECT_NEAR(rig.position(), 63'900, 600);
}

}  // namespace
}  // namespace sim
