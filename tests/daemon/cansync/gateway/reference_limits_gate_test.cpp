// What the gate makes of values that the master refuses for a limit.
#include "gate_rig.h"

namespace cansyncd {
namespace {

constexpr WriterHandle kWriter = 7;

/// A gate and a master whose value 0 is 100 at most; refusals come back as in the daemon.
class LimitedRig : public GateRig {
 public:
  LimitedRig() : GateRig(limited()) { line.master.set_reference_limits(0, {.maximum = 100}); }

  static Config limited() {
    Config config = default_config();
    config.failsafe.reference_deadline = std::chrono::milliseconds(20);
    config.master.process.reference_limits[0].maximum = 100;
    return config;
  }
  /// Writes a value in each of so many intervals.
  void write(std::uint32_t value, unsigned intervals) {
    for (unsigned i = 0; i < intervals; ++i) {
      take(values(kWriter, value));
      on_bus(1);
      for (; told_ < line.told.beyond_limits.size(); ++told_)
        gate.refused_for_limit(0, {gateway_CAUSE_FIELD, "above its maximum"}, std::nullopt, now());
      gate.tick(now());
      gate.push_stops();
    }
  }

 private:
  std::size_t told_ = 0;
};

TEST(ReferenceLimitsGate, RefusedSamplesAreToldOnceAndCounted) {
  LimitedRig rig;
  rig.write(100, 5);
  rig.write(101, 10);
  EXPECT_EQ(rig.told("reference_refused"), 1U);
  EXPECT_EQ(rig.gate.givers()[0].refused_reason, "above its maximum");
  EXPECT_EQ(rig.line.master.release(cansync::Channel::one).beyond_limits, 10U);
  rig.write(100, 1'100);
  EXPECT_EQ(rig.told("reference_refusals_over"), 1U);
}

TEST(ReferenceLimitsGate, SamplesBeyondALimitKeepNoDeadline) {
  LimitedRig rig;
  rig.write(100, 5);
  rig.write(101, 19);
  EXPECT_FALSE(rig.gate.take_reaction(0));
  rig.write(101, 3);
  EXPECT_EQ(rig.told("reference_deadline_missed"), 1U);
  EXPECT_TRUE(rig.gate.take_reaction(0));
  rig.write(101, 100);
  EXPECT_FALSE(rig.gate.take_return(0)) << "the loss has not ended";
  EXPECT_EQ(rig.cause(), "deadline_missed");
  rig.write(100, 2);
  EXPECT_TRUE(rig.gate.take_return(0));
  EXPECT_EQ(rig.cause(), "");
}

TEST(ReferenceLimitsGate, AWriterWhoseFirstSamplesAreBeyondALimitMissesItsDeadline) {
  LimitedRig rig;
  rig.write(101, 25);
  EXPECT_EQ(rig.told("reference_deadline_missed"), 1U);
  EXPECT_TRUE(rig.gate.take_reaction(0));
}

}  // namespace
}  // namespace cansyncd
