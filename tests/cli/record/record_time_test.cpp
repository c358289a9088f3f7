#include "cli/record/record_time.h"

#include <gtest/gtest.h>

namespace cansync::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr RecordTime::Time kBegin{seconds(1000)};

TEST(RecordTime, TheDurationCountsFromTheFirstRowAlsoWhenItComesLate) {
  RecordTime time(milliseconds(500), kBegin);
  EXPECT_GT(time.left(kBegin + seconds(9)).count(), 0);
  time.rows_are_there(kBegin + seconds(9));
  EXPECT_DOUBLE_EQ(time.left(kBegin + seconds(9)).count(), 0.5);
  time.rows_are_there(kBegin + milliseconds(9400));
  EXPECT_NEAR(time.seconds(kBegin + milliseconds(9400)), 0.4, 1e-9);
  EXPECT_NEAR(time.left(kBegin + milliseconds(9400)).count(), 0.1, 1e-9);
  EXPECT_LE(time.left(kBegin + milliseconds(9501)).count(), 0);
}

TEST(RecordTime, ARowAfterTenSecondsStillBeginsTheDuration) {
  RecordTime time(seconds(5), kBegin);
  EXPECT_NEAR(time.left(kBegin + seconds(12)).count(), 3, 1e-9);
  time.rows_are_there(kBegin + seconds(12));
  EXPECT_NEAR(time.left(kBegin + seconds(12)).count(), 5, 1e-9);
}

TEST(RecordTime, WithoutAnyRowItEndsTenSecondsAfterTheDuration) {
  const RecordTime time(milliseconds(500), kBegin);
  EXPECT_EQ(time.seconds(kBegin), 0);
  EXPECT_EQ(time.seconds(kBegin + seconds(10)), 0);
  EXPECT_GT(time.left(kBegin + milliseconds(10'400)).count(), 0);
  EXPECT_LE(time.left(kBegin + milliseconds(10'500)).count(), 0);
}

}  // namespace
}  // namespace cansync::cli
