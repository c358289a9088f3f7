#include "can/socketcan/frame_clock.h"

#include <gtest/gtest.h>

#include <chrono>

#include "fake_kernel.h"

namespace can::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

struct Rig {
  FakeKernel kernel;
  FrameClock clock{kernel};

  /// One batch with one frame, a millisecond after the last.
  StampedTime batch(const FrameStamps& stamps, bool complete = true) {
    clock.begin_batch();
    const StampedTime time = clock.translate(stamps);
    clock.end_batch(complete);
    return time;
  }
  FrameStamps software(Time at) const { return {at + kernel.wall_offset, std::nullopt}; }
};

TEST(FrameClock, KernelStampsAreTranslatedExactly) {
  Rig rig;
  rig.kernel.now += milliseconds(1);
  const Time at = rig.kernel.now - microseconds(137);
  const StampedTime time = rig.batch(rig.software(at));
  EXPECT_EQ(time.at, at);
  EXPECT_EQ(time.source, TimestampSource::kernel);
}

TEST(FrameClock, WithoutAStampTheLookIsTheTime) {
  Rig rig;
  rig.kernel.now += milliseconds(1);
  const StampedTime time = rig.batch({});
  EXPECT_EQ(time.at, rig.kernel.now);
  EXPECT_EQ(time.source, TimestampSource::thread);
}

TEST(FrameClock, WhereAReadingTakesLongOneIsEnoughUnlessItWasInterrupted) {
  Rig rig;
  rig.kernel.reading_takes = microseconds(3);
  const auto readings = [&rig] {
    rig.kernel.now += milliseconds(1);
    rig.kernel.clock_readings = 0;
    rig.batch({});
    return rig.kernel.clock_readings;
  };
  EXPECT_EQ(readings(), 3 * 2u) << "how long one takes is not known yet";
  EXPECT_EQ(readings(), 2u);
  rig.kernel.reading_takes = microseconds(4);
  EXPECT_EQ(readings(), 3 * 2u);
}

TEST(FrameClock, AFrameStampedBeforeTheWallClockWasSetKeepsItsTime) {
  Rig rig;
  rig.batch({});
  for (const Time step : {Time(seconds(3600)), Time(seconds(-3600)), Time(milliseconds(500))}) {
    rig.kernel.now += milliseconds(1);
    const Time at = rig.kernel.now - microseconds(200);
    const FrameStamps stamps = rig.software(at);
    rig.kernel.wall_offset += step;
    const StampedTime time = rig.batch(stamps);
    EXPECT_EQ(time.at, at);
    EXPECT_EQ(time.source, TimestampSource::kernel);
  }
}

TEST(FrameClock, AStampThatCannotBeIsNotUsed) {
  Rig rig;
  rig.batch({});
  rig.kernel.now += milliseconds(1);
  for (const Time wrong : {Time(seconds(10)), Time(seconds(-10))}) {
    const StampedTime time = rig.batch(rig.software(rig.kernel.now + wrong));
    EXPECT_EQ(time.at, rig.kernel.now);
    EXPECT_EQ(time.source, TimestampSource::thread);
  }
}

/// An overloaded kernel stamps a frame and hands it on later: it is no new one, whose answer would still be
/// in time.
TEST(FrameClock, AFrameThatWasLongOnItsWayKeepsItsTime) {
  Rig rig;
  for (const Time way : {Time(milliseconds(2)), Time(milliseconds(5)), Time(milliseconds(900))}) {
    rig.kernel.now += milliseconds(10);
    const Time at = rig.kernel.now;
    rig.kernel.now += way;
    rig.batch({});
    rig.kernel.now += microseconds(100);
    const StampedTime time = rig.batch(rig.software(at));
    EXPECT_EQ(time.at, at);
    EXPECT_EQ(time.source, TimestampSource::kernel);
  }
}

TEST(FrameClock, FramesThatWaitedForASecondBatchKeepTheirTime) {
  Rig rig;
  rig.batch({});
  rig.kernel.now += milliseconds(1);
  const Time at = rig.kernel.now;
  rig.kernel.now += milliseconds(1);
  rig.batch(rig.software(at), false);
  rig.kernel.now += milliseconds(10);
  EXPECT_EQ(rig.batch(rig.software(at)).at, at);
}

TEST(FrameClock, HardwareStampsGetTheLeastDelayAsOffset) {
  Rig rig;
  const Time start = rig.kernel.now;
  const Time hardware_start = milliseconds(77);
  StampedTime last;
  Time end{};
  for (unsigned i = 0; i < 200; ++i) {
    rig.kernel.now += milliseconds(1);
    end = rig.kernel.now - microseconds(300);
    // The driver needs 20 us, now and then up to 220.
    const Time delay = microseconds(20 + (i % 10) * 20);
    FrameStamps stamps = rig.software(end + delay);
    stamps.hardware = end - start + hardware_start;
    last = rig.batch(stamps);
    EXPECT_EQ(last.source, TimestampSource::hardware);
    if (i >= 10) {
      EXPECT_EQ(last.at, end + microseconds(20)) << "frame " << i;
    }
  }
}

TEST(FrameClock, AHardwareClockThatRunsSlowIsFollowed) {
  Rig rig;
  const Time start = rig.kernel.now;
  for (unsigned i = 0; i < 3000; ++i) {
    rig.kernel.now += milliseconds(1);
    const Time end = rig.kernel.now - microseconds(300);
    FrameStamps stamps = rig.software(end);
    const Time run = end - start;
    stamps.hardware = run - run / 10'000;  // 100 ppm
    const Time error = rig.batch(stamps).at - end;
    // Two windows of 64 ms at 100 ppm.
    EXPECT_LE(error, Time(0)) << "frame " << i;
    EXPECT_GE(error, -Time(microseconds(13))) << "frame " << i;
  }
}

TEST(FrameClock, AHardwareClockThatJumpsBeginsAnew) {
  Rig rig;
  Time jump{};
  for (unsigned i = 0; i < 100; ++i) {
    rig.kernel.now += milliseconds(1);
    const Time end = rig.kernel.now - microseconds(300);
    if (i == 50) jump = -Time(milliseconds(700));
    if (i == 75) jump = Time(seconds(40));
    FrameStamps stamps = rig.software(end + microseconds(15));
    stamps.hardware = end + jump;
    const StampedTime time = rig.batch(stamps);
    EXPECT_EQ(time.at, end + microseconds(15)) << "frame " << i;
    EXPECT_EQ(time.source, TimestampSource::hardware);
  }
}

TEST(FrameClock, NoFrameComesFromTheFuture) {
  Rig rig;
  rig.batch({});
  rig.kernel.now += milliseconds(1);
  EXPECT_EQ(rig.batch(rig.software(rig.kernel.now + microseconds(3))).at, rig.kernel.now);
}

}  // namespace
}  // namespace can::test
