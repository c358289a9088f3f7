#include "sync/clock_relation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace {

using namespace sync_line;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

Time hardware(Time at, double rate, Time offset = seconds(1'600'000'000)) {
  return at + offset +
         Time(std::llround(static_cast<double>((at - Time(seconds(100))).count()) * (rate - 1.0)));
}

TEST(ClockRelation, LearnsOffsetAndFrequencyFromNoisyReadings) {
  ClockRelation relation;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> noise(-300, 300);
  constexpr double kRate = 1.0 + 80e-6;
  Time now = seconds(100);
  for (int i = 0; i < 50; ++i, now += milliseconds(100)) {
    relation.add({now, hardware(now, kRate) + nanoseconds(noise(random)), nanoseconds(600)});
  }
  ASSERT_TRUE(relation.valid());
  EXPECT_NEAR(relation.line().rate, kRate, 1e-6);
  const Time later = now + milliseconds(100);
  EXPECT_LT(std::chrono::abs(relation.line().to_hardware(later) - hardware(later, kRate)), nanoseconds(600));
  EXPECT_LE(std::chrono::abs(relation.line().to_monotonic(relation.line().to_hardware(later)) - later),
            nanoseconds(1));
  EXPECT_EQ(relation.steps(), 0U);
}

TEST(ClockRelation, AReadingThatTookLongIsLeftOut) {
  ClockRelation relation;
  Time now = seconds(100);
  for (int i = 0; i < 10; ++i, now += milliseconds(100)) {
    relation.add({now, hardware(now, 1.0), nanoseconds(500)});
  }
  const ClockLine before = relation.line();
  relation.add({now, hardware(now, 1.0) + microseconds(15), microseconds(40)});
  EXPECT_EQ(relation.line().monotonic, before.monotonic);
  EXPECT_EQ(relation.line().hardware, before.hardware);
}

TEST(ClockRelation, ReadingsThatAllTakeLongAreBelievedInTheEnd) {
  ClockRelation relation;
  Time now = seconds(100);
  for (int i = 0; i < 10; ++i, now += milliseconds(100))
    relation.add({now, hardware(now, 1.0), nanoseconds(500)});
  for (int i = 0; i < 20; ++i, now += milliseconds(100))
    relation.add({now, hardware(now, 1.0), microseconds(9)});
  EXPECT_GT(relation.line().monotonic, Time(seconds(101)));
}

TEST(ClockRelation, AClockThatWasSetStartsAnew) {
  ClockRelation relation;
  Time now = seconds(100);
  for (int i = 0; i < 10; ++i, now += milliseconds(100)) {
    relation.add({now, hardware(now, 1.0), nanoseconds(500)});
  }
  // One wild reading changes nothing.
  relation.add({now, hardware(now, 1.0) + milliseconds(5), nanoseconds(500)});
  EXPECT_TRUE(relation.valid());
  EXPECT_EQ(relation.steps(), 0U);
  const Time offset = seconds(1'600'000'037);
  for (int i = 0; i < 10; ++i, now += milliseconds(100)) {
    relation.add({now, hardware(now, 1.0, offset), nanoseconds(500)});
  }
  EXPECT_EQ(relation.steps(), 1U);
  ASSERT_TRUE(relation.valid());
  EXPECT_LE(std::chrono::abs(relation.line().to_hardware(now) - hardware(now, 1.0, offset)), nanoseconds(2));
}

}  // namespace
