// The lead axis alone: each value for its interval, once. Rows of docs/cansync-cluster.md.
#include "cansync/cluster/lead_axis.h"

#include <gtest/gtest.h>

#include "cansync/settings/settings.h"

namespace cansync {
namespace {

using std::chrono::microseconds;

constexpr Duration kInTime = microseconds(200);

TEST(LeadAxisTest, K9AWordIsMadeLongerWithItsSignOrWithout) {
  ProcessMapping words = {};
  words[0].word[0] = {true, false, 0};
  for (const bool is_signed : {true, false}) {
    LeadSources sources = {};
    sources[4] = {LeadSource::Kind::reference, 0, {}, is_signed};
    LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
    lead.begin_interval(1);
    lead.took_references(Channel::one, 1, words, {0xFFFE}, kInTime);
    const auto update = lead.take(Channel::two);
    ASSERT_TRUE(update.has_value());
    EXPECT_EQ(update->value[0], is_signed ? 0xFFFFFFFEu : 0xFFFEu);
    EXPECT_FALSE(lead.take(Channel::two)) << "once an interval";
  }
}

TEST(LeadAxisTest, K9AShortTelegramDoesNotBringTheValue) {
  LeadSources sources = {};
  sources[4] = {LeadSource::Kind::reference, 1, {}, true};
  LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
  const ProcessMapping mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  lead.begin_interval(1);
  lead.took_references(Channel::one, 3, mapping, {1, 2, 3, 4, 5, 6, 7, 8}, kInTime);
  EXPECT_FALSE(lead.take(Channel::two));
  lead.begin_interval(2);
  lead.took_references(Channel::one, 4, mapping, {1, 2, 3, 4, 5, 6, 7, 8}, kInTime);
  EXPECT_TRUE(lead.take(Channel::two));
}

TEST(LeadAxisTest, K9OverSkippedIntervalsNothingIsCarried) {
  LeadSources sources = {};
  sources[0] = {LeadSource::Kind::reference, 0, {}, true};
  LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
  const ProcessMapping mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  for (const IntervalNumber next : {2u, 3u, 5u}) {
    lead.took_references(Channel::one, 4, mapping, {1, 2, 3, 4, 5, 6, 7, 8}, kInTime);
    lead.begin_interval(next);
    EXPECT_EQ(lead.take(Channel::one).has_value(), next == 3) << next;
  }
}

TEST(LeadAxisTest, K9AFrameThatIsReadAfterTheEdgeBelongsToTheIntervalBeforeIt) {
  LeadSources sources = {};
  sources[0] = sources[4] = {LeadSource::Kind::reference, 0, {}, true};
  LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
  ASSERT_EQ(lead.delay(0), 1u);
  ASSERT_EQ(lead.delay(4), 0u);
  const ProcessMapping mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  const auto take = [&](std::uint32_t value, Duration since_sync) {
    lead.took_references(Channel::one, 4, mapping, {value}, since_sync);
  };
  lead.begin_interval(1);
  lead.begin_interval(2);
  take(7, microseconds(-10));
  const auto next = lead.take(Channel::one);
  ASSERT_TRUE(next.has_value());
  EXPECT_EQ(next->value[0], 7u);
  EXPECT_FALSE(lead.take(Channel::two)) << "its interval is over";
  lead.begin_interval(3);
  EXPECT_FALSE(lead.take(Channel::one)) << "an interval too late";
  lead.begin_interval(4);
  take(8, microseconds(-1001));
  EXPECT_FALSE(lead.take(Channel::one)) << "of two intervals before";
}

}  // namespace
}  // namespace cansync
