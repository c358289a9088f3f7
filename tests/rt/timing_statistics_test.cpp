#include "rt/timing_statistics.h"

#include <gtest/gtest.h>

#include <chrono>

namespace {

using rt::TimingStatistics;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

TEST(TimingStatistics, SummarisesSinceTheLastTake) {
  TimingStatistics statistics;
  statistics.add(microseconds(3));
  statistics.add(microseconds(1));
  statistics.add(microseconds(8));
  const auto first = statistics.take();
  EXPECT_EQ(first.count, 3U);
  EXPECT_EQ(first.minimum, microseconds(1));
  EXPECT_EQ(first.mean, microseconds(4));
  EXPECT_EQ(first.maximum, microseconds(8));

  statistics.add(microseconds(20));
  const auto second = statistics.take();
  EXPECT_EQ(second.count, 1U);
  EXPECT_EQ(second.minimum, microseconds(20)) << "the earlier minimum is gone";

  const auto empty = statistics.take();
  EXPECT_EQ(empty.count, 0U);
  EXPECT_EQ(empty.mean, nanoseconds(0));
}

TEST(TimingStatistics, PutsEachValueIntoItsPowerOfTwo) {
  EXPECT_EQ(TimingStatistics::bucket(nanoseconds(-5)), 0U);
  EXPECT_EQ(TimingStatistics::bucket(nanoseconds(999)), 0U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(1)), 1U);
  EXPECT_EQ(TimingStatistics::bucket(nanoseconds(1'999)), 1U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(2)), 2U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(8'191)), 13U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(8'192)), 14U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(16'383)), 14U);
  EXPECT_EQ(TimingStatistics::bucket(microseconds(16'384)), 15U);
  EXPECT_EQ(TimingStatistics::bucket(std::chrono::hours(1)), 15U);
}

TEST(TimingStatistics, HistogramCountsSinceTheStart) {
  TimingStatistics statistics;
  statistics.add(microseconds(5));
  static_cast<void>(statistics.take());
  statistics.add(microseconds(6));
  statistics.add(milliseconds(100));
  EXPECT_EQ(statistics.histogram()[3], 2U);
  EXPECT_EQ(statistics.histogram()[15], 1U);
}

TEST(TimingStatistics, TheTotalGoesOnAndCountsWhatIsEarlyAsZero) {
  rt::TimingStatistics statistics;
  for (const int us : {5, -7, 20}) statistics.add(std::chrono::microseconds(us));
  (void)statistics.take();
  statistics.add(std::chrono::nanoseconds(1));
  EXPECT_EQ(statistics.total(), std::chrono::nanoseconds(25'001));
}

}  // namespace
