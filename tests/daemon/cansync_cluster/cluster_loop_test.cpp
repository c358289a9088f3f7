// Both buses of a cluster on one realtime thread, in virtual time.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <map>

#include "cluster_rig.h"
#include "daemon/cansync/state_text.h"
#include "daemon/cansync/texts/refusal_text.h"

namespace cansyncd::test {
namespace {

using cansync::BitRate;
using std::chrono::microseconds;
using std::chrono::seconds;

class ClusterLoop : public testing::TestWithParam<BitRate> {};

/// First doublewords of one telegram by the upper edge they belong to, counted from the first one.
std::map<long, std::uint32_t> by_edge(const LineTrace& trace, const LineTrace& upper,
                                      std::uint32_t identifier, can::Time interval) {
  std::map<long, std::uint32_t> found;
  for (const sim::TracedFrame& one : trace.frames) {
    if (one.frame.identifier() != identifier || one.frame.error || one.frame.dlc < 4) continue;
    std::uint32_t value = 0;
    std::memcpy(&value, one.frame.data.data(), sizeof(value));
    found[(one.start - upper.edges.front()) / interval] = value;
  }
  return found;
}

TEST_P(ClusterLoop, BothBusesComeToActiveOperationAndTheLowerSyncStandsWhereTheUpperDoes) {
  ClusterRig rig(GetParam());
  rig.run_until(2000 * rig.times.interval);
  EXPECT_EQ(rig.lower_snapshot.state, cansync::State::active_master);
  EXPECT_EQ(rig.upper_snapshot.state, cansync::State::active_slave);
  EXPECT_TRUE(rig.upper_snapshot.synchronized);
  EXPECT_EQ(rig.lower_snapshot.missed_syncs, 0u);
  ASSERT_GT(rig.lower_trace.edges.size(), 1000u);
  for (std::size_t n = 0; n < rig.lower_trace.edges.size(); ++n) {
    const can::Time edge = rig.lower_trace.edges[n];
    if (n > 0) {
      const can::Time length = edge - rig.lower_trace.edges[n - 1];
      EXPECT_LE(std::abs((length - rig.times.interval).count()), rig.times.interval.count() / 1000) << n;
    }
    const auto after = std::ranges::lower_bound(rig.upper_trace.edges, edge - rig.times.interval / 2);
    ASSERT_NE(after, rig.upper_trace.edges.end());
    if (n > 300) {
      EXPECT_LE(std::abs((edge - *after).count()), rig.times.interval.count() / 1000) << n;
    }
  }
}

TEST_P(ClusterLoop, ALeadAxisReachesWrc2BelowInTheSameInterval) {
  ClusterRig rig(GetParam());
  rig.run_until(1500 * rig.times.interval);
  const auto above = by_edge(rig.upper_trace, rig.upper_trace, 0x100 + kNumber, rig.times.interval);
  std::map<long, std::uint32_t> below;
  for (const std::uint32_t slave : {0u, 1u})
    below.merge(by_edge(rig.lower_trace, rig.upper_trace, 0x180 + slave, rig.times.interval));
  unsigned found = 0;
  for (const auto& [edge, value] : below) {
    if (edge < 1000) continue;
    const auto reference = above.find(edge);
    ASSERT_NE(reference, above.end()) << edge;
    EXPECT_EQ(value, reference->second) << edge;
    ++found;
  }
  EXPECT_GT(found, 400u);
}

TEST_P(ClusterLoop, AParameterOfADriveBelowIsReadFromAbove) {
  ClusterRig rig(GetParam());
  rig.at_interval(1000, [&] { rig.ask(1, kDriveNumber + 1, 301); });
  rig.at_interval(1200, [&] { rig.ask(2, 999, 301); });
  rig.run_until(1400 * rig.times.interval);
  ASSERT_TRUE(rig.asker.results[1] && rig.asker.results[2]);
  EXPECT_EQ(rig.asker.results[1]->outcome, cansync::Outcome::done);
  EXPECT_EQ(rig.asker.results[1]->value & 0x8000u, 0x8000u);
  EXPECT_EQ(rig.asker.results[2]->error, cansync::ParameterError::not_present);
  EXPECT_TRUE(rig.terminals.empty()) << "a job of the gateway reached the clients";
}

INSTANTIATE_TEST_SUITE_P(AllRates, ClusterLoop,
                         testing::Values(BitRate::mbit1, BitRate::kbit500, BitRate::kbit250,
                                         BitRate::kbit125));

TEST(ClusterLoop, TheLowerBusIsStoppedWithTheUpperSyncAndBeginsAgain) {
  ClusterRig rig;
  sim::Fault away;
  away.kind = sim::FaultKind::missing_sync;
  away.from = 1500;
  away.to = 1700;
  rig.upper_line_settings.faults = {away};
  rig.run_until(seconds(4));
  EXPECT_EQ(rig.lower_snapshot.state, cansync::State::active_master);
  EXPECT_EQ(rig.cluster->sync_losses(), 1u);
  bool stopped = false;
  for (const StateChanged& change : rig.told<StateChanged>()) {
    if (change.from == cansync::State::active_master && change.when.bus < seconds(2)) stopped = true;
  }
  EXPECT_TRUE(stopped);
  // Run through for the holdover, and then no edge until the upper ones are followed again.
  const auto made = [&](can::Time from, can::Time to) {
    return std::ranges::count_if(rig.lower_trace.edges, [&](can::Time at) { return at >= from && at < to; });
  };
  EXPECT_GT(made(microseconds(1'501'000), microseconds(1'515'000)), 12);
  EXPECT_EQ(made(microseconds(1'540'000), microseconds(1'690'000)), 0);
}

TEST(ClusterLoop, AClientMayNotGiveWhatTheLeadAxisGivesAndItsJobsGoBesideThoseOfTheGateway) {
  ClusterRig rig;
  rig.at_interval(1000, [&] {
    rig.ask(1, kDriveNumber, 301);
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.value = {1, 1, 1, 1};
      update.valid_mask = 0x0F;
      EXPECT_TRUE(rig.lower.requests.try_push(update));
    }
    cansync::ParameterRequest request;
    request.id = 7;
    request.slave = *cansync::SlaveNumber::from(0);
    request.number = *cansync::ParameterNumber::from(301);
    EXPECT_TRUE(rig.lower.requests.try_push(request));
  });
  rig.run_until(1200 * rig.times.interval);
  const auto refused = rig.told<ReferenceRefused>();
  ASSERT_EQ(refused.size(), 1u);
  EXPECT_EQ(refused[0].channel, cansync::Channel::two);
  EXPECT_EQ(refused[0].refusal, cansync::Refusal::lead_axis);
  ASSERT_EQ(rig.terminals.size(), 1u);
  const auto* done = std::get_if<ParameterDone>(&rig.terminals[0]);
  ASSERT_NE(done, nullptr);
  EXPECT_EQ(done->id, 7u);
  EXPECT_EQ(done->result.outcome, cansync::Outcome::done);
  ASSERT_TRUE(rig.asker.results[1]);
  EXPECT_EQ(rig.asker.results[1]->outcome, cansync::Outcome::done);
}

TEST(ClusterLoop, TheLimitsOfAReferenceValueHoldForTheLeadAxis) {
  constexpr std::uint32_t kMost = 0x11000000 + 1'200;  // the ramp above gets there
  ClusterRig rig;
  rig.cluster_settings.lower.process.reference_limits[4].maximum = kMost;
  rig.run_until(1500 * rig.times.interval);
  std::map<long, std::uint32_t> below;
  for (const std::uint32_t slave : {0u, 1u})
    below.merge(by_edge(rig.lower_trace, rig.upper_trace, 0x180 + slave, rig.times.interval));
  ASSERT_FALSE(below.empty());
  EXPECT_EQ(below.rbegin()->second, kMost) << "the limit itself is the last that goes down";
  const auto refused = rig.told<ReferenceRefused>();
  ASSERT_GT(refused.size(), 100u);
  EXPECT_EQ(refused[0].refusal, cansync::Refusal::beyond_limit);
  EXPECT_EQ(refused[0].channel, cansync::Channel::two);
  EXPECT_EQ(refused[0].beyond.number, kMost + 1);
  const cansync::LeadCounters& counters = rig.cluster->lead().counters(cansync::Channel::two);
  EXPECT_EQ(counters.refused, refused.size());
  EXPECT_GE(rig.lower_snapshot.release[1].beyond_limits + 1, refused.size()) << "as of the last interval";
}

TEST(ClusterLoop, AClientMayNotChangeTheMappingOfWhatTheLeadAxisGives) {
  ClusterRig rig;
  const cansync::ProcessMapping before = rig.cluster_settings.lower.process.reference_mapping;
  rig.at_interval(1000, [&] {
    SetReferenceMapping changed{8, before};
    changed.mapping[1].word = {};
    changed.mapping[1].word[0] = {true, false, 4};
    EXPECT_TRUE(rig.lower.requests.try_push(changed));
    SetReferenceMapping other{9, before};
    other.mapping[0].word = {};
    other.mapping[0].word[0] = {true, false, 1};
    EXPECT_TRUE(rig.lower.requests.try_push(other));
  });
  rig.run_until(1200 * rig.times.interval);
  ASSERT_EQ(rig.terminals.size(), 2u);
  const auto* refused = std::get_if<Refused>(&rig.terminals[0]);
  ASSERT_NE(refused, nullptr);
  EXPECT_EQ(refused->id, 8u);
  EXPECT_EQ(refused->refusal, cansync::Refusal::lead_axis);
  EXPECT_NE(std::get_if<CommandDone>(&rig.terminals[1]), nullptr) << "the other telegram is free";
  const auto& mapping = rig.cluster->lower().settings().process.reference_mapping;
  EXPECT_EQ(mapping[1], before[1]);
  EXPECT_NE(mapping[0], before[0]);
  // Every value still goes down whole.
  const auto above = by_edge(rig.upper_trace, rig.upper_trace, 0x100 + kNumber, rig.times.interval);
  unsigned found = 0;
  for (const auto& [edge, value] : by_edge(rig.lower_trace, rig.upper_trace, 0x180, rig.times.interval)) {
    if (edge < 1001 || !above.contains(edge)) continue;
    EXPECT_EQ(value, above.at(edge)) << edge;
    ++found;
  }
  EXPECT_GT(found, 50u);
  EXPECT_EQ(rig.cluster->lead().counters(cansync::Channel::two).refused, 0u);
}

TEST(ClusterLoop, EdgesForWhichTheThreadIsTooLateAreSkippedBelowAndNoneFollowsInABurst) {
  ClusterRig rig;
  rig.at(microseconds(1'500'000), [&] { rig.upper_bus->late = microseconds(1700); });
  rig.at(microseconds(1'504'000), [&] { rig.upper_bus->late = {}; });
  rig.run_until(seconds(3));
  EXPECT_GE(rig.lower_snapshot.missed_syncs, 1u);
  EXPECT_LE(rig.lower_snapshot.missed_syncs, 6u);
  EXPECT_EQ(rig.lower_snapshot.state, cansync::State::active_master);
  for (std::size_t n = 1; n < rig.lower_trace.edges.size(); ++n) {
    EXPECT_GE(rig.lower_trace.edges[n] - rig.lower_trace.edges[n - 1], rig.times.interval / 2) << n;
  }
}

TEST(ClusterLoop, SetUpIsLeftUntilTheUpperSyncIsThere) {
  ClusterRig rig;
  rig.master_settings.first_edge = seconds(1);
  rig.at(std::chrono::milliseconds(500), [&] {
    EXPECT_TRUE(rig.lower.requests.try_push(ModeRequest{3, Mode::set_up, false}));
  });
  rig.at(std::chrono::milliseconds(900), [&] {
    MasterSnapshot lower;
    ASSERT_TRUE(rig.lower.master.read(lower));
    EXPECT_TRUE(lower.waits_for_upper_sync);
    EXPECT_EQ(state_text(lower), "waiting for the SYNC of the upper bus");
    const RefusalContext line = {.state = lower.state, .waits_for_upper_sync = lower.waits_for_upper_sync};
    EXPECT_EQ(refusal_text(cansync::Refusal::wrong_state, ModeRequest{4, Mode::run, false}, Config{}, line),
              "state: the master is in stop (0x0003); run is entered from setup alone: the upper bus of the "
              "cluster has no SYNC: start that one first, then give mode setup, then mode run");
  });
  rig.run_until(seconds(2));
  EXPECT_TRUE(std::ranges::none_of(rig.lower_trace.edges, [](can::Time at) { return at < seconds(1); }));
  EXPECT_EQ(rig.lower_snapshot.state, cansync::State::setting_up_master);
  EXPECT_FALSE(rig.lower_snapshot.waits_for_upper_sync);
}

}  // namespace
}  // namespace cansyncd::test
