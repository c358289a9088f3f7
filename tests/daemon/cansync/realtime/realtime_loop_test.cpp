#include "daemon/cansync/realtime/realtime_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <set>
#include <vector>

#include "support/loop_rig.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using cansync::Channel;
using std::chrono::microseconds;

// --- the timeline

TEST(RealtimeLoop, ProducesEachEdgeOnTheAbsoluteTimeline) {
  LoopRig rig;
  rig.run_until(2000);
  ASSERT_GE(rig.bus.edges.size(), 1999U);
  const auto first = rig.bus.edges.front().first;
  EXPECT_EQ((first - rig.first_sync()) % rig.interval, can::Time{0});
  for (std::size_t i = 0; i < rig.bus.edges.size(); ++i) {
    ASSERT_EQ(rig.bus.edges[i].first, first + static_cast<int>(i) * rig.interval);
    ASSERT_EQ(rig.bus.edges[i].second, rig.bus.edges[i].first);
  }
  EXPECT_EQ(rig.snapshot().missed_syncs, 0U);
}

TEST(RealtimeLoop, LateWakeUpsDoNotMoveTheTimeline) {
  LoopRig rig;
  rig.bus.lateness = [](can::Time) { return microseconds(40); };
  rig.run_until(500);
  ASSERT_GE(rig.bus.edges.size(), 499U);
  for (const auto& [due, produced] : rig.bus.edges) {
    ASSERT_EQ((due - rig.first_sync()) % rig.interval, can::Time{0});
    ASSERT_EQ(produced - due, microseconds(40));
  }
}

TEST(RealtimeLoop, SkipsMissedEdgesAndNeverSendsABurst) {
  LoopRig rig;
  const auto stall_at = rig.first_sync() + 100 * rig.interval;
  // 5.3 intervals: edges 100 to 104 are lost, 105 is produced 0.3 intervals late.
  rig.bus.lateness = [&](can::Time deadline) {
    return deadline == stall_at ? can::Time(microseconds(5300)) : can::Time{0};
  };
  rig.run_until(200);
  std::set<can::Time> due;
  can::Time before{0};
  for (const auto& [edge, produced] : rig.bus.edges) {
    EXPECT_TRUE(due.insert(edge).second) << "produced twice";
    EXPECT_GE(produced - before, rig.interval / 2) << "two edges in a bunch";
    before = produced;
  }
  for (int n = 100; n < 105; ++n) EXPECT_EQ(due.count(rig.first_sync() + n * rig.interval), 0U) << n;
  EXPECT_EQ(due.count(rig.first_sync() + 105 * rig.interval), 1U);
  EXPECT_EQ(rig.snapshot().missed_syncs, 5U);
  const auto missed = rig.reported<SyncsMissed>();
  ASSERT_EQ(missed.size(), 1U);
  EXPECT_EQ(missed[0].count, 5U);
  EXPECT_EQ(missed[0].when.interval, 105U);
}

TEST(RealtimeLoop, AnEdgeNearerToTheNextOneIsSkippedToo) {
  LoopRig rig;
  const auto stall_at = rig.first_sync() + 100 * rig.interval;
  rig.bus.lateness = [&](can::Time deadline) {
    return deadline == stall_at ? can::Time(microseconds(1800)) : can::Time{0};
  };
  rig.run_until(200);
  can::Time before{0};
  for (const auto& [edge, produced] : rig.bus.edges) {
    EXPECT_GE(produced - before, rig.interval / 2);
    before = produced;
  }
  const auto missed = rig.reported<SyncsMissed>();
  ASSERT_EQ(missed.size(), 1U);
  EXPECT_EQ(missed[0].count, 2U);
  EXPECT_EQ(missed[0].when.interval, 102U);
}

// --- slots

TEST(RealtimeLoop, SendsEachTelegramAtItsPlannedStart) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one));
  rig.push_at(60, references(Channel::two));
  for (unsigned i = 0; i < 50; ++i) rig.push_at(61 + i, read_request(i + 1, 0, 1000 + i));
  rig.run_until(200);
  const auto& times = cansync::slot_times(cansync::BitRate::mbit1);
  const can::Time margin = microseconds(50);
  const auto one = rig.sent_on(cansync::identifier::reference_one);
  const auto two = rig.sent_on(cansync::identifier::reference_two);
  ASSERT_GT(one.size(), 100U);
  ASSERT_EQ(one.size(), two.size());
  for (const can::Time at : one) EXPECT_EQ(at % rig.interval, times.reference_one - margin);
  for (const can::Time at : two) EXPECT_EQ(at % rig.interval, times.reference_two - margin);
  unsigned in_active = 0;
  for (const can::Time at : rig.sent_on(cansync::identifier::command)) {
    if (at < 60 * rig.interval) continue;  // set-up, where commands go out early
    EXPECT_EQ(at % rig.interval, times.command - margin);
    ++in_active;
  }
  EXPECT_GE(in_active, 50U);
}

TEST(RealtimeLoop, CommandsGoOutEarlyInSetUp) {
  LoopRig rig(virtual_time(StartTarget::setup));
  rig.run_until(40);
  const auto commands = rig.sent_on(cansync::identifier::command);
  ASSERT_GE(commands.size(), 3U);
  const auto& times = cansync::slot_times(cansync::BitRate::mbit1);
  for (const can::Time at : commands) EXPECT_EQ(at % rig.interval, times.reference_one - microseconds(50));
  EXPECT_TRUE(rig.sent_on(cansync::identifier::reference_one).empty());
}

TEST(RealtimeLoop, LeavesATelegramOutWhenItsLatestStartHasPassed) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one));
  const auto& times = cansync::slot_times(cansync::BitRate::mbit1);
  const can::Time planned = times.reference_one - microseconds(50);
  const auto edge = rig.first_sync() + 100 * rig.interval;
  rig.bus.lateness = [&](can::Time deadline) {
    return deadline == edge + planned ? can::Time(microseconds(51)) : can::Time{0};
  };
  rig.run_until(150);
  const auto sent = rig.sent_on(cansync::identifier::reference_one);
  EXPECT_EQ(std::count(sent.begin(), sent.end(), 99 * rig.interval + planned), 1);
  EXPECT_EQ(std::count_if(sent.begin(), sent.end(), [&](can::Time at) { return at / rig.interval == 100; }),
            0);
  EXPECT_EQ(std::count(sent.begin(), sent.end(), 101 * rig.interval + planned), 1) << "back to normal";
  const auto counters = rig.snapshot().counters;
  EXPECT_EQ(counters.left_out, 1U);
  EXPECT_EQ(rig.bus.edges.size(), counters.intervals) << "the timeline goes on";
}

TEST(RealtimeLoop, AStartExactlyAtItsLatestIsStillInTime) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one));
  rig.bus.lateness = [](can::Time) { return microseconds(50); };
  rig.run_until(150);
  EXPECT_EQ(rig.snapshot().counters.left_out, 0U);
  const auto sent = rig.sent_on(cansync::identifier::reference_one);
  ASSERT_GT(sent.size(), 50U);
  for (const can::Time at : sent) EXPECT_EQ(at % rig.interval, microseconds(350));
}

TEST(RealtimeLoop, ReferenceValuesOfTheLastMomentStillMakeTheirSlot) {
  LoopRig rig;
  rig.at(100, microseconds(299),
         [&] { EXPECT_TRUE(rig.exchange.requests.try_push(references(Channel::one, 1))); });
  // A frame wakes the thread at 299 us; then it sleeps on until the slot.
  can::Frame noise;
  noise.id = 0x7FF;
  rig.bus.put(noise, rig.first_sync() + 100 * rig.interval + microseconds(299));
  rig.run_until(150);
  EXPECT_EQ(rig.sent_on(cansync::identifier::reference_one),
            std::vector<can::Time>{100 * rig.interval + microseconds(300)});
}

TEST(RealtimeLoop, ARefusedFrameIsLeftOutAndReportedOnTheEdge) {
  LoopRig rig;
  rig.push_at(60, references(Channel::one));
  rig.at(100, microseconds(0), [&] { rig.bus.send_result = can::SendResult::queue_full; });
  rig.at(110, microseconds(0), [&] { rig.bus.send_result = can::SendResult::queued; });
  rig.run_until(150);
  EXPECT_GE(rig.bus.refused.size(), 10U);
  EXPECT_EQ(rig.snapshot().counters.left_out, rig.bus.refused.size());
  const auto changes = rig.reported<SendingChanged>();
  ASSERT_EQ(changes.size(), 2U) << "two reports, not one for each telegram";
  EXPECT_EQ(changes[0].result, can::SendResult::queue_full);
  EXPECT_EQ(changes[1].result, can::SendResult::queued);
  EXPECT_EQ(changes[1].failed, rig.bus.refused.size());
}

}  // namespace
