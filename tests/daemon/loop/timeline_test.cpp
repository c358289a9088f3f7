#include "daemon/loop/timeline.h"

#include <gtest/gtest.h>

#include <chrono>

namespace cansyncd {
namespace {

using std::chrono::milliseconds;

TEST(Timeline, AnEdgeWithinHalfAnIntervalOfOneThatWasHeldUpIsSkipped) {
  Timeline timeline(milliseconds(8), std::nullopt);
  timeline.begin(milliseconds(8));
  EXPECT_EQ(timeline.skip_missed(milliseconds(8)).count, 0u);
  timeline.advance();
  timeline.made(milliseconds(14));  // the thread was held up between looking at the clock and making the edge
  const Timeline::Missed missed = timeline.skip_missed(milliseconds(16));
  EXPECT_EQ(missed.count, 1u);
  EXPECT_TRUE(missed.wait);
  EXPECT_EQ(timeline.due(), milliseconds(24));
  EXPECT_EQ(timeline.skip_missed(milliseconds(24)).count, 0u);
}

TEST(Timeline, AnEdgeHalfAnIntervalAfterALateOneIsMade) {
  Timeline timeline(milliseconds(8), std::nullopt);
  timeline.begin(milliseconds(8));
  timeline.advance();
  timeline.made(milliseconds(12));
  EXPECT_EQ(timeline.skip_missed(milliseconds(16)).count, 0u);
  EXPECT_EQ(timeline.due(), milliseconds(16));
}

TEST(Timeline, ALateWakeUpMakesRoomByItself) {
  Timeline timeline(milliseconds(8), std::nullopt);
  timeline.begin(milliseconds(8));
  timeline.advance();
  timeline.made(milliseconds(14));
  EXPECT_EQ(timeline.skip_missed(milliseconds(19)).count, 0u);  // 5 ms after the edge that was held up
}

}  // namespace
}  // namespace cansyncd
