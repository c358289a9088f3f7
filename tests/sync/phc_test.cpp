#include <gtest/gtest.h>

#include <cmath>

#include "sync/fake_system.h"
#include "sync/phc_output.h"

namespace {

using namespace sync_line;
using namespace sync_line::test;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr Time kInterval = milliseconds(1);

Time of(const ptp_clock_time& time) {
  return std::chrono::seconds(time.sec) + Time(time.nsec);
}

/// An output whose thread's work the test does.
struct Rig {
  explicit Rig(Edge edge = Edge::falling) : pin(pin_with(edge)), output(system, pin, kInterval) {
    for (int i = 0; i < 6; ++i) step();
  }
  static PhcPin pin_with(Edge edge) {
    PhcPin out;
    out.pin = 1;
    out.channel = 1;
    out.edge = edge;
    return out;
  }
  void step() {
    system.now += PhcOutput::kPeriod;
    output.step();
  }
  FakeSystem system;
  PhcPin pin;
  PhcOutput output;
};

TEST(PhcDevice, ProgramsThePin) {
  Rig rig;
  EXPECT_EQ(rig.system.pin.index, 1U);
  EXPECT_EQ(rig.system.pin.chan, 1U);
  EXPECT_EQ(rig.system.pin.func, static_cast<unsigned>(PTP_PF_PEROUT));
}

TEST(PhcDevice, AFallingEdgeStandsAtTheEndOfThePulse) {
  Rig rig;
  rig.output.want(true);
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 2U);
  const ptp_perout_request& request = rig.system.periodic[1];
  EXPECT_EQ(request.index, 1U);
  EXPECT_EQ(of(request.period), kInterval);
  EXPECT_EQ(request.flags, static_cast<unsigned>(PTP_PEROUT_DUTY_CYCLE));
  EXPECT_EQ((of(request.start) + of(request.on)) % kInterval, Time{0}) << "high until the SYNC edge";
  EXPECT_EQ(of(request.on), Time(microseconds(750)));
  EXPECT_GT(of(request.start), rig.system.hardware_at(rig.system.now)) << "in the driver's future";
}

TEST(PhcDevice, ARisingEdgeStandsAtTheStart) {
  Rig rig(Edge::rising);
  rig.output.want(true);
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 2U);
  EXPECT_EQ(of(rig.system.periodic[1].start) % kInterval, Time{0});
  EXPECT_EQ(of(rig.system.periodic[1].on), Time(microseconds(250)));
}

TEST(PhcDevice, WithoutAChosenPulseTheEdgeStaysWhereItWas) {
  Rig rig;
  rig.system.duty_cycle = false;
  rig.output.want(true);
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 2U);
  EXPECT_EQ(rig.system.periodic[1].flags, 0U);
  EXPECT_EQ((of(rig.system.periodic[1].start) + kInterval / 2) % kInterval, Time{0});
  EXPECT_EQ(rig.output.error(), 0);
}

TEST(PhcDevice, ReadsTheClockByTheBestWayThereIs) {
  FakeSystem precise;
  precise.caps.cross_timestamping = 1;
  PhcDevice first(precise, {});
  EXPECT_EQ(precise.asked.count(PTP_SYS_OFFSET_EXTENDED2), 0U);
  const auto exact = first.sample();
  ASSERT_TRUE(exact);
  EXPECT_EQ(exact->monotonic, precise.now);
  EXPECT_EQ(exact->hardware, precise.hardware_at(precise.now));

  FakeSystem old;
  old.control_error[PTP_SYS_OFFSET_EXTENDED2] = EOPNOTSUPP;
  PhcDevice second(old, {});
  const auto plain = second.sample();
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->hardware - plain->monotonic, old.hardware_offset);

  FakeSystem usual;
  PhcDevice third(usual, {});
  const auto narrow = third.sample();
  ASSERT_TRUE(narrow);
  EXPECT_EQ(narrow->uncertainty, usual.reading_width) << "the narrowest window counts";
  EXPECT_EQ(narrow->hardware, usual.hardware_at(usual.now));
}

TEST(PhcDevice, RefusalsNameOptionAndRemedy) {
  FakeSystem system;
  const auto refused = [&](PhcPin pin) { return refusal([&] { PhcDevice(system, pin); }); };
  PhcPin pin;
  pin.device = "/dev/ptp9";
  EXPECT_NE(refused(pin).find("sync.phc_device: /dev/ptp9: No such file or directory; plug"),
            std::string::npos);
  pin = {};
  pin.channel = 2;
  EXPECT_EQ(refused(pin), "sync.phc_channel: found 2; /dev/ptp0 has channels 0..1");
  pin = {};
  pin.pin = 4;
  EXPECT_EQ(refused(pin), "sync.phc_pin: found 4; /dev/ptp0 has pins 0..3");
  system.caps.n_pins = 0;
  pin.pin = 0;
  EXPECT_EQ(refused(pin), "sync.phc_pin: found 0; the pins of /dev/ptp0 are fixed, so give -1");
  pin.pin = -1;
  EXPECT_EQ(refused(pin), "");
  EXPECT_EQ(system.asked.count(PTP_PIN_SETFUNC2), 0U);
  system.caps.n_pins = 4;
  system.control_error[PTP_PIN_SETFUNC2] = EBUSY;
  EXPECT_NE(refused({}).find("sync.phc_pin: /dev/ptp0 pin 0: Device or resource busy"), std::string::npos);
  system.caps.n_per_out = 0;
  EXPECT_NE(refused({}).find("has no periodic output"), std::string::npos);
  system.open_error[FakeSystem::kPtp] = EACCES;
  EXPECT_NE(refused({}).find("sync.phc_device: /dev/ptp0: Permission denied"), std::string::npos);
  EXPECT_EQ(system.open_files, 0U);
}

TEST(PhcOutput, TheTimelineSeesEveryHardwareEdgeOnce) {
  Rig rig;
  rig.system.hardware_rate = 1.0 + 60e-6;
  rig.system.rate_from = rig.system.now;
  for (int i = 0; i < 30; ++i) rig.step();
  Time near = rig.system.now + microseconds(200);
  Time at{0};
  Time last{0};
  for (int i = 0; i < 50; ++i, near += kInterval) {
    ASSERT_TRUE(rig.output.take(near, at)) << i;
    EXPECT_FALSE(rig.output.take(near, at)) << "taken already";
    EXPECT_LE(std::chrono::abs(at - near), kInterval / 2 + Time(microseconds(1)));
    const Time hardware = rig.system.hardware_at(at);
    EXPECT_LT(std::abs(std::remainder(static_cast<double>(hardware.count()), 1e6)), 5.0) << "ns off the grid";
    if (last > Time{0}) {
      EXPECT_NEAR(static_cast<double>((at - last).count()), 1e6 / (1.0 + 60e-6), 2.0);
    }
    last = at;
  }
}

TEST(PhcOutput, SwitchesOnlyWhenAsked) {
  Rig rig;
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 1U);
  EXPECT_EQ(of(rig.system.periodic[0].period), Time{0})
      << "edges of a process that was killed end first of all";
  rig.output.want(true);
  rig.step();
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 2U);
  rig.output.want(false);
  rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 3U);
  EXPECT_EQ(of(rig.system.periodic[2].period), Time{0}) << "off";
}

TEST(PhcOutput, EdgesOfAKilledProcessAreEndedAsSoonAsThatWorks) {
  FakeSystem system;
  system.control_error[PTP_PEROUT_REQUEST2] = EBUSY;
  PhcOutput output(system, {}, kInterval);
  EXPECT_TRUE(system.periodic.empty());
  system.control_error.clear();
  system.now += PhcOutput::kPeriod;
  output.step();
  ASSERT_EQ(system.periodic.size(), 1U);
  EXPECT_EQ(of(system.periodic[0].period), Time{0});
}

TEST(PhcOutput, EdgesThatAreWantedAreStartedAlsoWhereTheOldOnesCouldNotBeEnded) {
  FakeSystem system;
  system.control_error[PTP_PEROUT_REQUEST2] = EBUSY;
  PhcOutput output(system, {}, kInterval);
  system.control_error.clear();
  output.want(true);
  system.now += PhcOutput::kPeriod;
  output.step();
  ASSERT_EQ(system.periodic.size(), 1U);
  EXPECT_EQ(of(system.periodic[0].period), kInterval);
}

TEST(PhcOutput, EndsTheEdgesWithItself) {
  FakeSystem system;
  {
    PhcOutput output(system, {}, kInterval);
    output.want(true);
    system.now += PhcOutput::kPeriod;
    output.step();
    ASSERT_EQ(system.periodic.size(), 2U);
  }
  ASSERT_EQ(system.periodic.size(), 3U);
  EXPECT_EQ(of(system.periodic[2].period), Time{0});
  EXPECT_EQ(system.open_files, 0U);
}

TEST(PhcOutput, AClockThatWasSetGetsItsEdgesAnew) {
  Rig rig;
  rig.output.want(true);
  rig.step();
  rig.system.hardware_offset += seconds(37);
  for (int i = 0; i < 10; ++i) rig.step();
  ASSERT_EQ(rig.system.periodic.size(), 3U);
  EXPECT_GT(of(rig.system.periodic[2].start), of(rig.system.periodic[1].start) + seconds(36));
  EXPECT_EQ(rig.output.clock_steps(), 1U);
}

TEST(PhcOutput, AClockThatCannotBeReadIsToldAndNotFollowed) {
  Rig rig;
  Time at{0};
  ASSERT_TRUE(rig.output.take(rig.system.now, at));
  rig.system.control_error[PTP_SYS_OFFSET_EXTENDED2] = ENODEV;
  for (int i = 0; i < 25; ++i) rig.step();
  EXPECT_EQ(rig.output.error(), ENODEV);
  EXPECT_FALSE(rig.output.take(rig.system.now, at)) << "the relation is stale";
  rig.system.control_error.clear();
  rig.step();
  EXPECT_EQ(rig.output.error(), 0);
  EXPECT_TRUE(rig.output.take(rig.system.now, at));
}

TEST(PhcOutput, TheWallClockBeingSetSpoilsNoReading) {
  Rig rig;
  rig.system.wall_offset += seconds(3600);
  rig.step();
  Time at{0};
  ASSERT_TRUE(rig.output.take(rig.system.now, at));
  EXPECT_EQ(rig.system.hardware_at(at) % kInterval, Time{0});
}

}  // namespace
