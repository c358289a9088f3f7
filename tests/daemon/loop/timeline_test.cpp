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

TEST(Timeline, OneThatIsLedTakesTheEdgesAndNumbersOfTheOther) {
  LeadingEdges edges{.passed = 0, .newest = {}, .next = milliseconds(10)};
  Timeline timeline(milliseconds(8), std::nullopt, &edges);
  timeline.begin(milliseconds(8));
  EXPECT_EQ(timeline.due(), milliseconds(10));
  // Its own clock has come there first: it waits until the edge has passed.
  EXPECT_TRUE(timeline.skip_missed(milliseconds(10)).wait);
  edges = {1, milliseconds(10), milliseconds(19)};
  const Timeline::Missed none = timeline.skip_missed(milliseconds(11));
  EXPECT_EQ(none.count, 0u);
  EXPECT_FALSE(none.wait);
  EXPECT_EQ(timeline.next(), 1u);
  EXPECT_EQ(timeline.due(), milliseconds(10));
  timeline.advance();
  EXPECT_EQ(timeline.due(), milliseconds(19));
}

TEST(Timeline, OneThatIsLedSkipsWhatHasPassedWithoutIt) {
  LeadingEdges edges{.passed = 4, .newest = milliseconds(32), .next = milliseconds(40)};
  Timeline timeline(milliseconds(8), std::nullopt, &edges);
  timeline.begin(milliseconds(8));
  edges = {7, milliseconds(56), milliseconds(64)};
  const Timeline::Missed late = timeline.skip_missed(milliseconds(57));
  EXPECT_EQ(late.count, 2u);
  EXPECT_FALSE(late.wait);
  EXPECT_EQ(timeline.next(), 7u);
  EXPECT_EQ(timeline.due(), milliseconds(56));
  const Timeline::Missed too_late = timeline.skip_missed(milliseconds(61));
  EXPECT_EQ(too_late.count, 1u);
  EXPECT_TRUE(too_late.wait);
  EXPECT_EQ(timeline.due(), milliseconds(64));
}

}  // namespace
}  // namespace cansyncd
