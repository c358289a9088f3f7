#include "text/counts.h"

#include <gtest/gtest.h>

namespace text {
namespace {

using namespace std::chrono_literals;

TEST(Counts, OneIsSingularAndEveryOtherNumberPlural) {
  EXPECT_EQ(counted(1, "slave"), "1 slave");
  EXPECT_EQ(counted(0, "slave"), "0 slaves");
  EXPECT_EQ(counted(32u, "SYNC edge"), "32 SYNC edges");
  EXPECT_EQ(counted(-1, "interval"), "-1 intervals");
}

TEST(Counts, PluralsThatAreNoMereS) {
  EXPECT_EQ(counted(2, "reply"), "2 replies");
  EXPECT_EQ(counted(2, "day"), "2 days");
  EXPECT_EQ(counted(2, "address"), "2 addresses");
  EXPECT_EQ(counted(2, "batch"), "2 batches");
  EXPECT_EQ(counted(1, "edge was", "edges were"), "1 edge was");
  EXPECT_EQ(counted(2, "edge was", "edges were"), "2 edges were");
}

TEST(Counts, OfSeveralTheWholeDecides) {
  EXPECT_EQ(counted_of(1, 32, "slave"), "1 of 32 slaves");
  EXPECT_EQ(counted_of(0, 1, "slave responds", "slaves respond"), "0 of 1 slave responds");
}

TEST(Durations, StandInTheGreatestUnitThatFits) {
  EXPECT_EQ(duration_text(3000ms), "3 s");
  EXPECT_EQ(duration_text(1500ms), "1.5 s");
  EXPECT_EQ(duration_text(1000us), "1 ms");
  EXPECT_EQ(duration_text(250ms), "250 ms");
  EXPECT_EQ(duration_text(62500ns), "62.5 us");
  EXPECT_EQ(duration_text(40ns), "40 ns");
  EXPECT_EQ(duration_text(0ns), "0 s");
  EXPECT_EQ(duration_text(-1250us), "-1.25 ms");
}

TEST(Durations, DigitsBehindTheThirdAreLeftOut) {
  EXPECT_EQ(duration_text(1'000'400ns), "1 ms");
  EXPECT_EQ(duration_text(1'234'567us), "1.234 s");
  EXPECT_EQ(duration_text(2'040ms), "2.04 s");
}

}  // namespace
}  // namespace text
