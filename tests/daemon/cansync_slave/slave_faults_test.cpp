// What the slave's realtime machine does about edges and reference values that stay away, in virtual time.
#include <gtest/gtest.h>

#include "can/flagged_frames.h"
#include "cansync/telegram/telegram.h"
#include "daemon/cansync_slave/realtime/slave_machine.h"
#include "slave_rig.h"

namespace cansyncd {
namespace {

using namespace test;
using cansync::SlaveFault;
using cansync::SlaveReaction;

TEST(SlaveMachineTest, OneMissingEdgeIsRunThrough) {
  SlaveRig rig(cansync::BitRate::mbit1, {missing_edges(1500, 1)});
  rig.run_until(2000 * rig.times.interval);
  EXPECT_EQ(rig.snapshot.missing_edges, 1u);
  EXPECT_TRUE(rig.snapshot.synchronized);
  EXPECT_EQ(rig.snapshot.fault, SlaveFault::none);
}

TEST(SlaveMachineTest, EdgesMissingForLongerThanTheHoldOverEndSynchronism) {
  SlaveRig rig(cansync::BitRate::mbit1, {missing_edges(1500, 400)});
  rig.run_until(1800 * rig.times.interval);
  EXPECT_FALSE(rig.snapshot.synchronized);
  EXPECT_EQ(rig.snapshot.status_word, 0x0000);
  EXPECT_EQ(rig.snapshot.fault, SlaveFault::sync_lost);
  EXPECT_EQ(rig.snapshot.reaction, SlaveReaction::quick_stop);
  const auto changes = rig.told<SynchronizedReport>();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_TRUE(changes[0].synchronized);
  EXPECT_FALSE(changes[1].synchronized);
}

TEST(SlaveMachineTest, AnotherSlaveOfItsNumberIsToldOnceAndNoMoreWhenItHasItsOwn) {
  SlaveRig rig;
  const auto other = [&rig](std::uint64_t interval, std::uint32_t number) {
    rig.at(interval * rig.times.interval, [&rig, number] {
      rig.bus->give(can::test::data_frame(cansync::identifier::actual_one + number, {1, 2, 3, 4}));
    });
  };
  other(1500, kNumber);
  other(1510, kNumber);
  other(1520, kNumber + 1);
  rig.run_until(1600 * rig.times.interval);
  const auto told = rig.told<OwnNumberReport>();
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].identifier, cansync::identifier::actual_one + kNumber);
  EXPECT_EQ(rig.snapshot.own_number_frames, 2u);
}

TEST(SlaveMachineTest, MissingReferenceValuesAreAFaultUntilTheyComeAgain) {
  SlaveRig rig;
  rig.at(1500 * rig.times.interval, [&rig] {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}}) rig.master->set_reference(value, {});
  });
  rig.at(1600 * rig.times.interval,
         [&rig] { rig.master->set_reference(0, {.kind = sim::ReferenceCurve::Kind::constant}); });
  rig.run_until(1700 * rig.times.interval);
  const auto faults = rig.told<FaultReport>();
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].fault, SlaveFault::references_missing);
  EXPECT_FALSE(faults[0].over);
  // Ten intervals without: the edge that ends the tenth tells.
  const auto references = rig.told<ReferencesReport>();
  IntervalNumber last = 0;
  for (const ReferencesReport& one : references) {
    if (one.values.interval[0] < faults[0].when.interval) last = one.values.interval[0];
  }
  EXPECT_EQ(faults[0].when.interval - last, 11u);
  EXPECT_TRUE(faults[1].over);
  EXPECT_EQ(rig.snapshot.fault, SlaveFault::none);
}

/// The master gives reference values, or none.
void references_at(SlaveRig& rig, can::Time when, bool given) {
  const auto kind = given ? sim::ReferenceCurve::Kind::constant : sim::ReferenceCurve::Kind::none;
  rig.at(when, [&rig, kind] {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}})
      rig.master->set_reference(value, {.kind = kind});
  });
}

/// A master that dies takes both with it.
TEST(SlaveMachineTest, EdgesAndReferenceValuesThatStayAwayAreTwoFaultsWithTheirOwnReactions) {
  cansync::SlaveSupervisionSettings supervision;
  supervision.on_references_missing = SlaveReaction::report;
  supervision.on_sync_lost = SlaveReaction::pulse_inhibit;
  SlaveRig rig(cansync::BitRate::mbit1, {missing_edges(1500, 400)}, {}, supervision);
  const can::Time interval = rig.times.interval;
  references_at(rig, 1500 * interval, false);
  references_at(rig, 1700 * interval, true);
  const auto standing = [&rig](SlaveFault fault, SlaveReaction reaction) {
    EXPECT_TRUE(rig.exchange.status.read(rig.snapshot));
    EXPECT_EQ(rig.snapshot.fault, fault);
    EXPECT_EQ(rig.snapshot.reaction, reaction);
  };
  rig.at(1515 * interval, [&] { standing(SlaveFault::references_missing, SlaveReaction::report); });
  rig.at(1600 * interval, [&] { standing(SlaveFault::sync_lost, SlaveReaction::pulse_inhibit); });
  rig.at(1800 * interval, [&] { standing(SlaveFault::sync_lost, SlaveReaction::pulse_inhibit); });
  rig.run_until(3000 * interval);
  EXPECT_EQ(rig.snapshot.fault, SlaveFault::none);
  EXPECT_TRUE(rig.snapshot.synchronized);
  const auto faults = rig.told<FaultReport>();
  ASSERT_EQ(faults.size(), 4u);
  EXPECT_EQ(faults[0].fault, SlaveFault::references_missing);
  EXPECT_EQ(faults[0].reaction, SlaveReaction::report);
  EXPECT_EQ(faults[1].fault, SlaveFault::sync_lost);
  EXPECT_EQ(faults[1].reaction, SlaveReaction::pulse_inhibit);
  EXPECT_EQ(faults[2].fault, SlaveFault::references_missing);
  EXPECT_TRUE(faults[2].over) << "reference values come again";
  EXPECT_EQ(faults[3].fault, SlaveFault::sync_lost);
  EXPECT_TRUE(faults[3].over) << "synchronized";
  EXPECT_LT(faults[2].when.bus, faults[3].when.bus);
}

/// Frames tell a thread of each edge that it slept through; without them it finds the edges all at once.
TEST(SlaveMachineTest, AThreadThatStoodStillForLessThanTheHoldOverHasLostNoEdge) {
  cansync::SlaveSupervisionSettings supervision;
  supervision.misses_until_fault = 0;
  SlaveRig rig(cansync::BitRate::mbit1, {}, {}, supervision);
  const can::Time interval = rig.times.interval;
  references_at(rig, 1500 * interval, false);
  rig.at(1550 * interval + interval / 2,
         [&rig, interval] { rig.bus->stand_still(rig.bus->now() + 10 * interval); });
  rig.run_until(1700 * interval);
  EXPECT_TRUE(rig.snapshot.synchronized);
  EXPECT_EQ(rig.snapshot.missing_edges, 0u);
  EXPECT_TRUE(rig.told<FaultReport>().empty());
  ASSERT_EQ(rig.told<SynchronizedReport>().size(), 1u);
}

}  // namespace
}  // namespace cansyncd
