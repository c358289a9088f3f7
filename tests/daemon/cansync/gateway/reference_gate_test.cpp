#include "daemon/cansync/gateway/reference_gate.h"

#include <functional>

#include "gate_rig.h"

/// The gate and a master in virtual time: what becomes of the values of writers that come, give up and go.
namespace cansyncd {
namespace {

using Seen = std::vector<unsigned>;
constexpr WriterHandle kWeak = 1;
constexpr WriterHandle kStrong = 2;

/// A weak writer of strength 1 and a strong one of strength 2.
class Gate : public ::testing::Test, public GateRig {
 protected:
  explicit Gate(const Config& config = default_config()) : GateRig(config) {
    strength = {{kWeak, 1}, {kStrong, 2}};
  }
};

TEST_F(Gate, AStrongWriterThatGivesUpEndsItsReleaseAlsoWhileAWeakerOneLives) {
  take(values(kWeak, 11, 1000));
  EXPECT_EQ(on_bus(2), (Seen{11, 11}));
  const ReferenceSample old = values(kWeak, 12, 1000);
  take(values(kStrong, 22, 1000));
  EXPECT_EQ(count_on_bus(100, 22), 100u);
  EXPECT_EQ(told("reference_writer_taken_over"), 1u);
  EXPECT_EQ(cause(), "");

  take(last_of(kStrong));
  EXPECT_EQ(count_on_bus(1000, 22), 0u) << "telegrams with the value that was given up";
  EXPECT_EQ(told("reference_given_up"), 1u);
  EXPECT_NE(text("reference_given_up").find("writer 2"), std::string::npos);
  EXPECT_EQ(told("reference_writer_lost"), 0u);
  EXPECT_EQ(cause(), "given_up");
  EXPECT_EQ(gate.owner(0), 0u);
  EXPECT_TRUE(gate.take_reaction(0));
  EXPECT_FALSE(gate.take_reaction(0)) << "once";

  // What the weaker one wrote before is old, what it writes now is taken.
  take(old);
  EXPECT_EQ(on_bus(5), Seen{});
  take(values(kWeak, 13));
  EXPECT_EQ(on_bus(5), (Seen{13}));
  EXPECT_EQ(cause(), "used_up");
}

TEST_F(Gate, WhatWasWrittenBeforeTheGivingUpIsNotTakenAfterIt) {
  take(values(kStrong, 22, 1000));
  const ReferenceSample on_its_way = values(kWeak, 11);
  EXPECT_EQ(count_on_bus(10, 22), 10u);
  take(last_of(kStrong));
  take(on_its_way);  // 10 ms old: young enough by its age
  EXPECT_EQ(on_bus(5), Seen{});
  EXPECT_NE(text("reference_refused").find("before the telegram was given up"), std::string::npos);
  take(values(kWeak, 12));
  EXPECT_EQ(on_bus(5), (Seen{12}));
}

TEST_F(Gate, AClockThatWasSetBackAfterTheGivingUpKeepsNobodyOut) {
  take(values(kStrong, 22, 5));
  EXPECT_EQ(count_on_bus(10, 22), 5u);
  take(last_of(kStrong));
  ReferenceSample sample = values(kWeak, 11);
  sample.written -= 3'600'000'000'000;
  gate.take(sample, wall() - 3'600'000'000'000, now());
  EXPECT_EQ(on_bus(3), (Seen{11}));
}

TEST_F(Gate, GivingUpOfAWeakerWriterChangesNothing) {
  take(values(kStrong, 22, 5));
  take(last_of(kWeak));
  EXPECT_EQ(count_on_bus(10, 22), 5u);
  EXPECT_EQ(told("reference_given_up"), 0u);
  EXPECT_FALSE(gate.take_reaction(0));
}

TEST_F(Gate, GivingUpEndsAtOnceAlsoWhereLossesAreHeld) {
  Config config = default_config();
  config.failsafe.reaction = LossReaction::hold;
  config.failsafe.hold_intervals = 50;
  GateRig rig(config);
  rig.take(rig.values(kStrong, 22, 1000));
  EXPECT_EQ(rig.count_on_bus(3, 22), 3u);
  rig.take(rig.last_of(kStrong));
  EXPECT_EQ(rig.on_bus(60), Seen{});
  rig.take(rig.values(kStrong, 23, 1000));
  EXPECT_EQ(rig.count_on_bus(3, 23), 3u);
  rig.gate.lost(0, rig.wall(), rig.now());
  EXPECT_EQ(rig.count_on_bus(60, 23), 50u) << "lost: held";
}

TEST_F(Gate, WhatGrowsTooOldOfAWriterThatHasGivenUpIsNoOtherLoss) {
  take(values(kStrong, 22, 1000));
  take(last_of(kStrong));
  EXPECT_TRUE(gate.take_reaction(0));
  std::array<cansync::ReleaseStatus, cansync::kChannels> release = {};
  release[0].too_old = 1;
  gate.watch(release, now());
  EXPECT_EQ(gate.givers()[0].loss, Loss::given_up);
  EXPECT_FALSE(gate.take_reaction(0));
  take(values(kWeak, 11, 1000));
  release[0].too_old = 2;
  gate.watch(release, now());
  EXPECT_EQ(gate.givers()[0].loss, Loss::too_old);
}

TEST_F(Gate, WhyASampleWasRefusedIsShownAlsoWhenItsWriterHasGone) {
  take(values(kStrong, 22, 1000));
  gate.refused_for_limit(0, {gateway_CAUSE_FIELD, "above its maximum"}, std::nullopt, now());
  take(last_of(kStrong));
  (void)gate.tick(now());
  EXPECT_EQ(gate.givers()[0].refused_reason, "above its maximum");
  EXPECT_EQ(gate.givers()[0].who, "");
}

TEST_F(Gate, AWriterThatIsNoStrongerWaitsUntilTheOwnerIsLost) {
  constexpr WriterHandle kEqual = 3;
  for (const WriterHandle waiting : {kWeak, kEqual}) {
    SCOPED_TRACE(waiting);
    GateRig rig;
    rig.strength = {{kWeak, 1}, {kStrong, 2}, {kEqual, 2}};
    rig.take(rig.values(kStrong, 22, 1000));
    rig.take(rig.values(waiting, 11, 5));
    EXPECT_EQ(rig.count_on_bus(5, 22), 5u);
    EXPECT_EQ(rig.told("writer_waits"), 1u);
    rig.take(rig.values(waiting, 12, 5));
    EXPECT_EQ(rig.told("writer_waits"), 1u) << "on the change";
    (void)rig.gate.tick(rig.now());
    EXPECT_EQ(rig.gate.givers()[0].waiting, "writer " + std::to_string(waiting));
    EXPECT_EQ(rig.gate.givers()[0].refused, 2u);
    EXPECT_NE(rig.gate.givers()[0].refused_reason.find("writer 2 has"), std::string::npos);

    const ReferenceSample on_its_way = rig.values(waiting, 13, 5);
    EXPECT_EQ(rig.count_on_bus(2, 22), 2u);
    rig.gate.lost(0, rig.wall(), rig.now());
    EXPECT_EQ(rig.on_bus(5), Seen{}) << "nothing that it gave while it waited";
    rig.take(on_its_way);
    EXPECT_EQ(rig.on_bus(5), Seen{}) << "nor what it wrote before the owner was lost";
    rig.take(rig.values(waiting, 14, 2));
    EXPECT_EQ(rig.on_bus(5), (Seen{14, 14}));
    EXPECT_EQ(rig.told("reference_writer_taken_over"), 0u);
    (void)rig.gate.tick(rig.now());
    EXPECT_EQ(rig.gate.givers()[0].waiting, "");
  }
}

TEST_F(Gate, ValuesThatFindNoRoomAreRefusedAndThoseAfterThemTaken) {
  take(values(kStrong, 22, 1000));
  EXPECT_EQ(on_bus(2), (Seen{22, 22}));
  full = true;
  take(values(kStrong, 23, 1000));
  EXPECT_NE(text("reference_refused").find("request queue full"), std::string::npos);
  EXPECT_EQ(on_bus(2), (Seen{22, 22}));
  full = false;
  take(values(kStrong, 24, 1000));
  EXPECT_EQ(on_bus(2), (Seen{24, 24}));
}

TEST_F(Gate, ValuesWaitForTheStopThatFindsNoRoom) {
  take(values(kStrong, 22, 1000));
  EXPECT_EQ(on_bus(2), (Seen{22, 22}));
  full = true;
  take(last_of(kStrong));
  take(values(kWeak, 11, 1000));
  EXPECT_NE(text("reference_refused").find("the stop of its release waits for room"), std::string::npos);
  full = false;
  take(values(kWeak, 12));
  EXPECT_EQ(on_bus(3), (Seen{12})) << "the stop came before them";
}

struct Spoiled {
  const char* name;
  std::function<void(GateRig&, ReferenceSample&)> spoil;
};

// The stronger writer counts from its first sample, whatever that is refused for.
TEST_F(Gate, NothingOfTheWeakerWriterGoesOutAfterATakeOver) {
  const Spoiled cases[] = {
      {"good", [](GateRig&, ReferenceSample&) {}},
      {"interval passed", [](GateRig&, ReferenceSample& s) { s.update.from_interval = 1; }},
      {"field out of range",
       [](GateRig&, ReferenceSample& s) {
         s.problem = {gateway_CAUSE_FIELD, "valid 0: out of range"};
       }},
      {"too old", [](GateRig&, ReferenceSample& s) { s.written -= 2'000'000'000; }},
      {"another start", [](GateRig&, ReferenceSample& s) { s.daemon = {9}; }},
      {"no start", [](GateRig&, ReferenceSample& s) { s.daemon = {}; }},
      {"another mapping", [](GateRig&, ReferenceSample& s) { s.update.mapping_number = 7; }},
      {"no room", [](GateRig& rig, ReferenceSample&) { rig.full = true; }},
  };
  for (const Spoiled& c : cases) {
    SCOPED_TRACE(c.name);
    GateRig rig;
    rig.strength = {{kWeak, 1}, {kStrong, 2}};
    rig.take(rig.values(kWeak, 11, 3));
    for (unsigned i = 0; i < 15; ++i) {
      ReferenceSample later = rig.values(kWeak, 11);
      later.update.from_interval = rig.line.next_interval + 4 + 2 * i;
      rig.take(later);
    }
    EXPECT_EQ(rig.count_on_bus(1, 11), 1u);
    ReferenceSample first = rig.values(kStrong, 22);
    c.spoil(rig, first);
    rig.take(first);
    rig.full = false;
    rig.gate.push_stops();
    EXPECT_EQ(rig.count_on_bus(20, 11), 0u) << "of the weaker after the take-over";
    EXPECT_EQ(rig.gate.owner(0), kStrong);
    EXPECT_EQ(rig.told("reference_writer_taken_over"), 1u);
    rig.take(rig.values(kStrong, 23));
    EXPECT_EQ(rig.on_bus(30), (Seen{23}));
  }
}

TEST_F(Gate, ValuesForAnotherStartOfTheDaemonMoveNothing) {
  ReferenceSample old = values(kStrong, 22, 1000);
  old.daemon = {0xAB, 0xCD};
  for (int i = 0; i < 5; ++i) {
    old.written = wall();
    take(old);
    EXPECT_EQ(on_bus(1), Seen{});
  }
  EXPECT_EQ(told("reference_refused"), 1u) << "on the edge";
  const std::string why = text("reference_refused");
  EXPECT_NE(why.find(gateway::dds::name(gateway_CAUSE_OTHER_DAEMON)), std::string::npos) << why;
  EXPECT_NE(why.find("abcd0000"), std::string::npos) << why;
  EXPECT_NE(why.find("another start of the daemon"), std::string::npos) << why;
  EXPECT_NE(why.find("take_up"), std::string::npos) << why;
  EXPECT_EQ(told("reference_writer_began"), 0u);
  (void)gate.tick(now() + std::chrono::seconds(2));
  EXPECT_NE(text("reference_refusals_over").find("5 were before"), std::string::npos);

  ReferenceSample none = values(kStrong, 22, 1000);
  none.daemon = {};
  take(none);
  EXPECT_EQ(on_bus(1), Seen{});
  take(values(kStrong, 23, 2));
  EXPECT_EQ(on_bus(5), (Seen{23, 23}));
}

TEST_F(Gate, ASampleWithoutADaemonIsRefusedWithTheMembersName) {
  ReferenceSample none = values(kStrong, 22);
  none.daemon = {};
  take(none);
  EXPECT_NE(text("reference_refused").find("MasterStatus.daemon"), std::string::npos)
      << text("reference_refused");
}

TEST_F(Gate, AChangedMappingEndsTheReleaseAndIsToldOnce) {
  take(values(kStrong, 22, 1000));
  EXPECT_EQ(count_on_bus(3, 22), 3u);
  cansync::ProcessMapping mapping = line.master.settings().process.reference_mapping;
  mapping[0].word[0] = {true, false, 1};
  ASSERT_EQ(line.master.set_reference_mapping(mapping), cansync::Refusal::none);
  EXPECT_EQ(on_bus(20), Seen{});
  EXPECT_EQ(told("reference_mapping_changed"), 1u);
  EXPECT_EQ(cause(), "mapping_changed");
  EXPECT_TRUE(gate.take_reaction(0));
  take(values(kStrong, 23, 1000));
  EXPECT_EQ(on_bus(5), Seen{});
  EXPECT_FALSE(gate.take_return(0)) << "values that are refused take no reaction back";
  const std::string why = text("reference_refused");
  EXPECT_NE(why.find(gateway::dds::name(gateway_CAUSE_MAPPING_CHANGED)), std::string::npos) << why;
  ReferenceSample fitting = values(kStrong, 24, 1000);
  fitting.update.mapping_number = line.master.mapping_number();
  take(fitting);
  EXPECT_TRUE(gate.take_return(0));
}

TEST_F(Gate, AProgramThatTriesATelegramOfTheLeadAxisGetsNoPartInIt) {
  gate.set_lead_axis({true, false});
  take(values(kWeak, 11, 1000));
  EXPECT_EQ(on_bus(3), Seen{});
  EXPECT_EQ(gate.owner(0), 0u);
  EXPECT_EQ(told("reference_writer_began"), 0u);
  const std::string why = text("reference_refused");
  EXPECT_NE(why.find(gateway::dds::name(gateway_CAUSE_RIGHT)), std::string::npos) << why;
  EXPECT_NE(why.find("[[lead]]"), std::string::npos) << why;
  take(last_of(kWeak));
  gate.lost(0, wall(), now());
  EXPECT_FALSE(gate.take_reaction(0));
  EXPECT_EQ(told("reference_given_up") + told("reference_writer_lost"), 0u);
  ReferenceSample other = values(kWeak, 12);
  other.telegram = 2;
  take(other);
  EXPECT_EQ(gate.owner(1), kWeak);
}

TEST_F(Gate, WhoWasThereBeforeTheLeadAxisWasKnownLosesNothing) {
  take(values(kWeak, 11, 1000));
  gate.set_lead_axis({true, false});
  EXPECT_EQ(gate.owner(0), 0u);
  EXPECT_EQ(gate.givers()[0].who, "");
  gate.lost(0, wall(), now());
  EXPECT_FALSE(gate.take_reaction(0));
}

/// The telegrams as the realtime thread tells of them; the lead axis gives the first one.
class LeadAxisGate : public Gate {
 protected:
  LeadAxisGate() {
    gate.set_lead_axis({true, false});
    give();
  }
  void give() {
    release[0].updates += 20;
    release[0].state = cansync::ReleaseStatus::State::released;
  }
  void grow_old() {
    ++release[0].too_old;
    release[0].state = cansync::ReleaseStatus::State::stopped;
  }
  /// Is the reaction due, and are values back?
  std::pair<bool, bool> look() {
    gate.watch(release, now());
    return {gate.take_reaction(0), gate.take_return(0)};
  }

  using Look = std::pair<bool, bool>;
  std::array<cansync::ReleaseStatus, cansync::kChannels> release = {};
};

TEST_F(LeadAxisGate, EachLossOfItsValuesHasItsReactionAndTheirReturnIsTold) {
  EXPECT_EQ(look(), (Look{false, false}));
  for (int loss = 0; loss < 2; ++loss) {
    grow_old();
    EXPECT_EQ(look(), (Look{true, false})) << loss;
    EXPECT_EQ(look(), (Look{false, false})) << loss;
    give();
    EXPECT_EQ(look(), (Look{false, true})) << loss;
    give();
    EXPECT_EQ(look(), (Look{false, false})) << loss;
  }
}

TEST_F(LeadAxisGate, WhatHappensBetweenTwoLooksIsSeenInItsOrder) {
  give();
  grow_old();
  EXPECT_EQ(look(), (Look{true, false})) << "given, then lost";
  give();
  grow_old();
  EXPECT_EQ(look(), (Look{true, false})) << "back, and lost again";
  give();
  grow_old();
  give();
  EXPECT_EQ(look(), (Look{true, true})) << "lost, and back again";
}

TEST_F(LeadAxisGate, AMappingThatChangesTheOtherTelegramIsNoLoss) {
  ++release[0].mapping_changed;
  EXPECT_EQ(look(), (Look{false, false}));
  EXPECT_EQ(told("reference_mapping_changed"), 0u);
}

TEST_F(Gate, ValuesThatTheRealtimeThreadRefusesKeepNoDeadlineOfThoseReleased) {
  Config config = default_config();
  config.failsafe.reference_deadline = std::chrono::milliseconds(100);
  GateRig rig(config);
  rig.take(rig.values(kWeak, 11, 1000));
  const auto write_on = [&](bool refused) {
    for (unsigned i = 0; i < 10; ++i) {
      ReferenceSample next = rig.values(kWeak, 12, 1000);
      if (refused) next.update.from_interval = 1;  // long past
      rig.take(next);
      (void)rig.on_bus(20);
      (void)rig.gate.tick(rig.now());
    }
    return rig.gate.take_reaction(0);
  };
  EXPECT_FALSE(write_on(false));
  EXPECT_TRUE(write_on(true));
}

TEST_F(Gate, ATakeOverThatIsRefusedBeginsTheDeadlineAnew) {
  Config config = default_config();
  config.failsafe.reference_deadline = std::chrono::milliseconds(100);
  GateRig rig(config);
  rig.strength = {{kWeak, 1}, {kStrong, 2}};
  rig.take(rig.values(kWeak, 11, 1000));
  (void)rig.on_bus(50);
  ReferenceSample first = rig.values(kStrong, 22);
  first.problem = {gateway_CAUSE_FIELD, "valid 0"};
  rig.take(first);
  (void)rig.on_bus(99);
  (void)rig.gate.tick(rig.now());
  EXPECT_FALSE(rig.gate.take_reaction(0));
  (void)rig.on_bus(1);
  (void)rig.gate.tick(rig.now());
  EXPECT_TRUE(rig.gate.take_reaction(0));
}

}  // namespace
}  // namespace cansyncd
