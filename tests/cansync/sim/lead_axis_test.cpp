// The lead axis alone: each value for its interval, once. Rows of docs/cansync-cluster.md.
#include "cansync/cluster/lead_axis.h"

#include <gtest/gtest.h>

#include "cansync/settings/settings.h"

namespace cansync {
namespace {

using std::chrono::microseconds;

TEST(LeadAxisTest, K9AWordIsMadeLongerWithItsSignOrWithout) {
  ProcessMapping words = {};
  words[0].word[0] = {true, false, 0};
  for (const bool is_signed : {true, false}) {
    LeadSources sources = {};
    sources[4] = {LeadSource::Kind::reference, 0, {}, is_signed};
    LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
    lead.begin_interval(1);
    lead.took_references(Channel::one, 1, words, {0xFFFE});
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
  lead.took_references(Channel::one, 3, mapping, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_FALSE(lead.take(Channel::two));
  lead.begin_interval(2);
  lead.took_references(Channel::one, 4, mapping, {1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_TRUE(lead.take(Channel::two));
}

TEST(LeadAxisTest, K9OverSkippedIntervalsNothingIsCarried) {
  LeadSources sources = {};
  sources[0] = {LeadSource::Kind::reference, 0, {}, true};
  LeadAxis lead(sources, BitRate::mbit1, default_send_margin(BitRate::mbit1), microseconds(50));
  const ProcessMapping mapping = {default_mapping(Channel::one), default_mapping(Channel::two)};
  for (const IntervalNumber next : {2u, 3u, 5u}) {
    lead.took_references(Channel::one, 4, mapping, {1, 2, 3, 4, 5, 6, 7, 8});
    lead.begin_interval(next);
    EXPECT_EQ(lead.take(Channel::one).has_value(), next == 3) << next;
  }
}

}  // namespace
}  // namespace cansync
