#include "cansync/sim/drive_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "drive_rig.h"

// The axis: reference values, extrapolation, faults, control word.
namespace sim {
namespace {

TEST(ReferenceTracker, CarriesOnWithTheLastSpeed) {
  ReferenceTracker tracker;
  EXPECT_FALSE(tracker.seen());
  tracker.take(1000);
  tracker.miss();
  EXPECT_EQ(tracker.value(), 1000) << "one value gives no speed";
  tracker.take(1020);
  tracker.take(1030);
  tracker.miss();
  tracker.miss();
  EXPECT_EQ(tracker.value(), 1050);
  EXPECT_EQ(tracker.misses(), 2u);
  tracker.take(1060);
  tracker.miss();
  EXPECT_EQ(tracker.value(), 1070) << "30 increments in 3 intervals";
}

TEST(ReferenceTracker, UnwrapsDoublewordsAndWords) {
  ReferenceTracker tracker;
  tracker.take(0x7FFFFFFF);
  tracker.take(0x80000001);
  EXPECT_EQ(tracker.value(), 2147483649.0);
  ReferenceTracker word(true);
  word.take(0xFFFE);
  EXPECT_EQ(word.value(), -2);
  word.take(0x0003);
  EXPECT_EQ(word.value(), 3);
}

TEST(ReferenceTracker, ForgettingKeepsWhereItStoodButNotTheSpeed) {
  ReferenceTracker tracker;
  tracker.take(0x7FFFFFF0);
  tracker.take(0x80000010);
  tracker.forget();
  EXPECT_FALSE(tracker.seen());
  tracker.miss();
  EXPECT_EQ(tracker.value(), 2147483664.0);
  tracker.take(0x80000020);
  EXPECT_EQ(tracker.value(), 2147483680.0);
  tracker.miss();
  EXPECT_EQ(tracker.value(), 2147483680.0);
}

TEST(DriveMotion, FirstOrderLagReachesTheTargetExactly) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 5; ++i) rig.follow(1000);
  EXPECT_NEAR(rig.position(), 1000 * (1 - std::exp(-1.0)), 1) << "5 ms of lag after 5 ms";
  for (int i = 0; i < 100; ++i) rig.follow(1000);
  EXPECT_EQ(rig.position(), 1000);
  EXPECT_TRUE(rig.has(status_bit::on_target));
  EXPECT_TRUE(rig.has(status_bit::standstill));
  for (int i = 0; i < 100'000; ++i) rig.follow(0);
  EXPECT_EQ(rig.drive.motion().position(), 0);
}

TEST(DriveMotion, RampIsFollowedWithConstantErrorAndSpeed) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 500; ++i) rig.follow(i * 100);
  EXPECT_NEAR(rig.speed(), 100'000, 1);
  EXPECT_GT(rig.actual(2), 100);
  EXPECT_LT(rig.actual(2), 1000);
  EXPECT_EQ(rig.actual(3), 49'900) << "setpoint";
  EXPECT_NEAR(rig.actual(3) - rig.position(), rig.actual(2), 1);
  EXPECT_NEAR(rig.actual(4), 30, 1) << "no acceleration: friction alone";
}

TEST(DriveMotion, AccelerationNeedsTorqueAndLoadWarms) {
  DriveRig rig;
  rig.lock();
  rig.follow(0);
  rig.follow(100'000);
  EXPECT_GT(rig.actual(4), 1000);
  const std::int32_t cold = rig.actual(6);
  EXPECT_NEAR(cold, 250, 2);
  for (int i = 0; i < 2000; ++i) rig.follow(i % 20 < 10 ? 100'000 : 0);
  EXPECT_GT(rig.actual(6), cold + 10);
}

TEST(DriveMotion, PositionWrapsWithTheBus) {
  DriveRig rig;
  rig.lock();
  std::int64_t wanted = 2'147'000'000;
  for (int i = 0; i < 30'000; ++i) rig.follow(static_cast<std::int32_t>(wanted));
  EXPECT_EQ(rig.position(), 2'147'000'000);
  for (int i = 0; i < 1000; ++i) {
    wanted += 1000;
    rig.follow(static_cast<std::int32_t>(static_cast<std::uint32_t>(wanted & 0xFFFFFFFF)));
    ASSERT_NEAR(rig.speed(), 500'000, 500'001) << "no jump at the turn";
  }
  EXPECT_LT(rig.position(), 0);
}

TEST(DriveMotion, ChangeOfModeBeyondTheTurnMakesNoJump) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 40'000; ++i) rig.follow(2'147'000'000);
  for (int i = 0; i < 100; ++i) rig.follow(-2'147'000'000);
  ASSERT_EQ(rig.position(), -2'147'000'000);
  rig.drive.set_parameter(parameter::operating_mode, 1);
  rig.edge();
  EXPECT_EQ(rig.position(), -2'147'000'000);
  rig.drive.set_parameter(parameter::operating_mode, 0);
  rig.follow(-2'147'000'000);
  EXPECT_EQ(rig.speed(), 0);
}

TEST(DriveMotion, GearOffsetAndOwnReferenceValue) {
  DriveSettings settings = rig_settings();
  settings.axis = {5, 1, std::nullopt, -2.5, 100};
  DriveRig rig(settings);
  rig.lock();
  for (int i = 0; i < 200; ++i) {
    rig.reference(999'999);
    rig.reference(0, 40, cansync::Channel::two);
    rig.edge();
  }
  EXPECT_EQ(rig.position(), 0);
}

TEST(DriveMotion, WordReferenceIsSigned) {
  DriveSettings settings = rig_settings();
  settings.slave.reference_mapping[0] = {};
  settings.slave.reference_mapping[0].word[0] = {true, false, 0};
  DriveRig rig(settings);
  rig.lock();
  for (int i = 0; i < 200; ++i) rig.follow(-300);
  EXPECT_EQ(rig.position(), -300);
}

TEST(DriveMotion, SpeedModeFollowsReferenceValueOne) {
  DriveRig rig;
  rig.drive.set_parameter(parameter::operating_mode, 1);
  rig.lock();
  for (int i = 0; i < 200; ++i) {
    rig.reference(12345, -50'000);
    rig.edge();
  }
  EXPECT_EQ(rig.speed(), -50'000);
  for (int i = 0; i < 5; ++i) rig.edge();
  EXPECT_EQ(rig.speed(), -50'000) << "a missing speed is held";
  for (int i = 0; i < 400; ++i) {
    rig.reference(0, 2'000'000'000);
    rig.edge();
  }
  EXPECT_EQ(rig.speed(), 100'000'000) << "maximum speed";
}

TEST(DriveMotion, MaximumSpeedLimitsAJump) {
  DriveRig rig;
  rig.drive.set_parameter(parameter::maximum_speed, 50'000);
  rig.lock();
  rig.follow(1'000'000);
  EXPECT_EQ(rig.speed(), 50'000);
  EXPECT_EQ(rig.position(), 50);
}

// --- missing reference values

TEST(MissingReferences, AreExtrapolatedWithTheLastSpeed) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 500; ++i) rig.follow(i * 100);
  rig.edges(9);
  EXPECT_TRUE(rig.has(status_bit::extrapolating));
  EXPECT_NEAR(rig.speed(), 100'000, 1);
  EXPECT_EQ(rig.actual(3), 49'900 + 900);
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  rig.follow(50'900);
  EXPECT_FALSE(rig.has(status_bit::extrapolating));
  EXPECT_NEAR(rig.speed(), 100'000, 1);
  EXPECT_EQ(rig.drive.missed_references(), 9u);
}

TEST(MissingReferences, FaultAfterTheSettableNumberAndRampDown) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 500; ++i) rig.follow(i * 1000);
  rig.edges(9);
  ASSERT_EQ(rig.drive.fault(), fault_code::none);
  rig.edge();
  EXPECT_EQ(rig.drive.fault(), fault_code::references_missing);
  EXPECT_TRUE(rig.has(status_bit::fault));
  EXPECT_FALSE(rig.has(status_bit::powered));
  // 10^7 increments/s^2 take 1,000,000 increments/s down in 100 ms.
  rig.edges(50);
  EXPECT_NEAR(rig.speed(), 490'000, 5000);
  rig.edges(60);
  EXPECT_EQ(rig.speed(), 0);
  EXPECT_TRUE(rig.has(status_bit::standstill));
}

TEST(MissingReferences, NeverSeenIsNoFault) {
  DriveRig rig;
  rig.lock();
  rig.edges(1000);
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  EXPECT_EQ(rig.drive.missed_references(), 0u);
}

TEST(MissingReferences, SupervisionCanBeSwitchedOff) {
  DriveSettings settings = rig_settings();
  settings.misses_until_fault = 0;
  DriveRig rig(settings);
  rig.lock();
  rig.follow(0);
  rig.edges(1000);
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
}

TEST(MissingReferences, TelegramWithoutDataIsNoReference) {
  DriveRig rig;
  rig.lock();
  rig.follow(0);
  cansync::ReferenceTelegram empty;
  empty.words = 0;
  for (int i = 0; i < 10; ++i) {
    rig.send(empty);
    rig.edge();
  }
  EXPECT_EQ(rig.drive.fault(), fault_code::references_missing);
}

TEST(MissingReferences, FaultResetLetsItFollowAgain) {
  DriveRig rig;
  rig.lock();
  rig.follow(100);
  rig.edges(50);
  ASSERT_EQ(rig.drive.fault(), fault_code::references_missing);
  for (int i = 0; i < 100; ++i) rig.follow(5000);
  EXPECT_NE(rig.position(), 5000) << "a fault holds until it is reset";
  rig.control(control_bit::run | control_bit::fault_reset);
  for (int i = 0; i < 100; ++i) rig.follow(5000);
  EXPECT_EQ(rig.position(), 5000);
  EXPECT_TRUE(rig.has(status_bit::following));
}

TEST(MissingReferences, AfterAFaultResetTheNextReferenceIsWaitedFor) {
  DriveRig rig;
  rig.lock();
  rig.follow(100);
  rig.edges(50);
  rig.control(control_bit::run | control_bit::fault_reset);
  const std::uint32_t missed = rig.drive.missed_references();
  rig.edges(50);
  EXPECT_EQ(rig.drive.fault(), fault_code::none);
  EXPECT_EQ(rig.drive.missed_references(), missed);
}

TEST(MissingReferences, TheFirstFaultIsKept) {
  DriveRig rig;
  rig.lock();
  rig.drive.raise_fault(77);
  rig.follow(100);
  rig.edges(50);
  EXPECT_EQ(rig.drive.fault(), 77);
}

TEST(MissingReferences, OnlyTheTelegramThatCarriesTheAxisCounts) {
  DriveRig rig;
  rig.lock();
  rig.follow(0);
  for (int i = 0; i < 10; ++i) {
    rig.reference(1, 1, cansync::Channel::two);
    rig.edge();
  }
  EXPECT_EQ(rig.drive.fault(), fault_code::references_missing);
}

// --- control word

TEST(ControlWord, WaitsForItWhenSetSo) {
  DriveSettings settings = rig_settings();
  settings.initial_control_word = 0;
  DriveRig rig(settings);
  rig.lock();
  for (int i = 0; i < 50; ++i) rig.follow(1000);
  EXPECT_EQ(rig.position(), 0);
  EXPECT_FALSE(rig.has(status_bit::powered));
  rig.control(control_bit::run);
  for (int i = 0; i < 100; ++i) rig.follow(1000);
  EXPECT_EQ(rig.position(), 1000);
  EXPECT_TRUE(rig.has(status_bit::powered));
}

TEST(ControlWord, DisableCoastsQuickStopBrakes) {
  DriveRig coasting;
  DriveRig braking;
  for (DriveRig* rig : {&coasting, &braking}) {
    rig->lock();
    for (int i = 0; i < 500; ++i) rig->follow(i * 1000);
  }
  coasting.control(0);
  braking.control(control_bit::enable | control_bit::follow);
  EXPECT_TRUE(braking.has(status_bit::quick_stop));
  for (int i = 0; i < 150; ++i) {
    coasting.follow(0);
    braking.follow(0);
  }
  EXPECT_EQ(braking.speed(), 0);
  EXPECT_GT(coasting.speed(), 500'000) << "friction alone";
  EXPECT_EQ(coasting.actual(4), 0) << "no power, no torque";
}

TEST(ControlWord, WithoutFollowItStandsPowered) {
  DriveRig rig;
  rig.lock();
  for (int i = 0; i < 100; ++i) rig.follow(500);
  rig.control(control_bit::enable | control_bit::no_quick_stop);
  for (int i = 0; i < 100; ++i) rig.follow(9000);
  EXPECT_EQ(rig.position(), 500);
  EXPECT_TRUE(rig.has(status_bit::powered));
  EXPECT_FALSE(rig.has(status_bit::following));
}

TEST(ControlWord, DoesNotFollowBeforeItIsSynchronized) {
  DriveRig rig;
  for (int i = 0; i < 50; ++i) rig.follow(500);
  EXPECT_EQ(rig.position(), 0);
}

TEST(ControlWord, UserCommand128ProvokesAFault) {
  DriveRig rig;
  rig.lock();
  rig.send(DriveRig::action(128, 0, 1234));
  EXPECT_EQ(rig.drive.fault(), 1234);
  rig.control(control_bit::run | control_bit::fault_reset);
  EXPECT_EQ(rig.drive.fault(), 0);
}

}  // namespace
}  // namespace sim
