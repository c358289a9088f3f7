#include "layer2/range_filter.h"

#include <gtest/gtest.h>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;

constexpr ReceiveRange range(std::uint32_t first, std::uint32_t last,
                             FrameKinds kinds = FrameKinds::data_and_remote) {
  return {first, last, false, kinds};
}

TEST(RangeFilter, WithoutARangeNothingIsTaken) {
  const RangeFilter filter;
  for (const can::Frame& frame : can::test::four_kinds()) EXPECT_FALSE(filter.match(frame));
}

// The entry that a module of the CAN 300 family has when nothing was set: 0x000 to 0x7FF is everything.
TEST(RangeFilter, TheWholeRangeOfElevenBitsTakesEverythingOfElevenBits) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add(range(0x000, 0x7FF)));
  for (std::uint32_t identifier = 0; identifier <= 0x7FF; ++identifier) {
    EXPECT_EQ(filter.match(data_frame(identifier, {})), 0) << identifier;
    EXPECT_EQ(filter.match(remote(data_frame(identifier, {1}))), 0) << identifier;
    EXPECT_FALSE(filter.match(extended(data_frame(identifier, {})))) << identifier;
  }
}

TEST(RangeFilter, LimitsBelongToTheRange) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add(range(0x180, 0x1FF)));
  EXPECT_FALSE(filter.match(data_frame(0x17F, {})));
  EXPECT_EQ(filter.match(data_frame(0x180, {})), 0);
  EXPECT_EQ(filter.match(data_frame(0x1FF, {})), 0);
  EXPECT_FALSE(filter.match(data_frame(0x200, {})));
}

TEST(RangeFilter, OneIdentifierIsARange) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add({0x18DAF110, 0x18DAF110, true, FrameKinds::data_and_remote}));
  EXPECT_EQ(filter.match(extended(data_frame(0x18DAF110, {}))), 0);
  EXPECT_FALSE(filter.match(extended(data_frame(0x18DAF10F, {}))));
  EXPECT_FALSE(filter.match(extended(data_frame(0x18DAF111, {}))));
}

TEST(RangeFilter, WidthsAreApart) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add({0x000, 0x1FFFFFFF, true, FrameKinds::data_and_remote}));
  EXPECT_FALSE(filter.match(data_frame(0x123, {})));
  EXPECT_EQ(filter.match(extended(data_frame(0x123, {}))), 0);
  EXPECT_EQ(filter.match(extended(data_frame(0x1FFFFFFF, {}))), 0);
}

TEST(RangeFilter, KindsAreApart) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add(range(0x100, 0x1FF, FrameKinds::data)));
  ASSERT_TRUE(filter.add(range(0x180, 0x27F, FrameKinds::remote)));
  EXPECT_EQ(filter.match(data_frame(0x180, {})), 0);
  EXPECT_EQ(filter.match(remote(data_frame(0x180, {}))), 1);
  EXPECT_FALSE(filter.match(remote(data_frame(0x100, {}))));
  EXPECT_FALSE(filter.match(data_frame(0x200, {})));
}

TEST(RangeFilter, TheFirstOfSeveralCounts) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add(range(0x300, 0x3FF)));
  ASSERT_TRUE(filter.add(range(0x000, 0x7FF)));
  EXPECT_EQ(filter.match(data_frame(0x3A0, {})), 0);
  EXPECT_EQ(filter.match(data_frame(0x400, {})), 1);
}

TEST(RangeFilter, ErrorFramesAreNeverTaken) {
  RangeFilter filter;
  ASSERT_TRUE(filter.add(range(0x000, 0x7FF)));
  EXPECT_FALSE(filter.match(can::test::error(data_frame(0x008, {}))));
}

TEST(RangeFilter, WrongRangesAreRefused) {
  EXPECT_EQ(check(range(0x7FF, 0x800)), RangeProblem::identifier_too_large);
  EXPECT_EQ(check(range(0x800, 0x000)), RangeProblem::identifier_too_large);
  EXPECT_EQ(check({0, 0x20000000, true}), RangeProblem::identifier_too_large);
  EXPECT_EQ(check({0, 0x1FFFFFFF, true}), RangeProblem::none);
  EXPECT_EQ(check(range(0x101, 0x100)), RangeProblem::reversed);
  EXPECT_EQ(check(range(0x100, 0x100)), RangeProblem::none);
  RangeFilter filter;
  EXPECT_FALSE(filter.add(range(0x101, 0x100)));
  EXPECT_EQ(filter.size(), 0u);
}

TEST(RangeFilter, TheirNumberIsBounded) {
  RangeFilter filter;
  for (std::uint32_t i = 0; i < RangeFilter::kMostRanges; ++i) ASSERT_TRUE(filter.add(range(i, i))) << i;
  EXPECT_FALSE(filter.add(range(0x700, 0x700)));
  EXPECT_EQ(filter.match(data_frame(63, {})), 63);
  EXPECT_FALSE(filter.match(data_frame(0x700, {})));
}

}  // namespace
}  // namespace layer2
