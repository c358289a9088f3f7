// Clusters: a slave of an upper line that is the master of a lower one (O 7.1.1). Each test carries the row
// of docs/cansync-cluster.md that it tries.
#include <gtest/gtest.h>

#include <algorithm>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::ClusterState;
using cansync::LeadSource;
using cansync::Outcome;
using cansync::State;
using std::chrono::microseconds;

class ClusterAcceptance : public ::testing::TestWithParam<BitRate> {};
INSTANTIATE_TEST_SUITE_P(AllRates, ClusterAcceptance,
                         ::testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                           BitRate::mbit1));

TEST_P(ClusterAcceptance, K1ASlaveOfTheUpperBusIsTheMasterOfTheLower) {
  Levels net(GetParam());
  net.start();
  net.run(20);
  EXPECT_GT(net.ends.actual.size() + net.judge.count[0x100], 0u);
  EXPECT_TRUE(net.upper_master().slave(*SlaveNumber::from(kGatewayA)).synchronized);
  for (unsigned n = 0; n < 3; ++n) {
    EXPECT_TRUE(net.cluster().lower().slave(*SlaveNumber::from(n)).synchronized);
  }
  EXPECT_EQ(net.middle[2]->slave.state(), State::active_slave);
}

TEST(Cluster, K2TheTwoNodesAreSlaveAndMasterWithABusEach) {
  Levels net;
  net.start();
  EXPECT_EQ(net.cluster().upper().state(), State::active_slave);
  EXPECT_EQ(net.cluster().lower().state(), State::active_master);
  // A job of somebody else at the lower master ends there, one of the gateway does not show.
  auto request = net.read(0, 20);
  request.slave = SlaveNumber{};
  ASSERT_EQ(net.cluster().lower().submit(request), cansync::Refusal::none);
  EXPECT_EQ(net.end_of(net.read(kMiddle + 1, 20)).outcome, Outcome::done);
  EXPECT_EQ(net.ends_a.parameters.size(), 1u);
  EXPECT_TRUE(net.ends_a.parameters.contains(request.id));
}

TEST(Cluster, K9ALateSlotBelowDoesNotTakeTheValuesOfTheNextInterval) {
  Levels net;
  net.a.cluster.lead[4] = {LeadSource::Kind::actual, 0, {}, true};
  net.start();
  cansync::Cluster& cluster = net.cluster();
  const cansync::IntervalNumber next = cluster.lower().interval() + 2;
  cluster.begin_above(next - 1);
  cluster.begin_below(next - 1);
  cluster.begin_above(next);
  EXPECT_FALSE(cluster.take(cansync::Slot::reference_two)) << "the slot of the interval before";
  cluster.release_actual(cansync::Channel::one, {77});
  cluster.begin_below(next);
  EXPECT_TRUE(cluster.take(cansync::Slot::reference_two));
}

TEST(Cluster, K3EveryParticipantHasANumberOf16Bits) {
  Levels net;
  net.a.cluster.gateway.routes.push_back(Levels::route(65535, 2, 0));
  net.a.cluster.gateway.own_number = {40000};
  net.start();
  EXPECT_EQ(net.end_of(net.read(65535, 20)).value, LeafSlave::initial(kMiddle + 2, 20));
  // Its own number and 0 are the gateway itself.
  EXPECT_EQ(net.end_of(net.read(40000, kStatusWord)).value, 0x8007u);
  EXPECT_EQ(net.end_of(net.read(0, kStatusWord)).value, 0x8007u);
  const auto unknown = net.end_of(net.read(2, 20));
  EXPECT_EQ(unknown.outcome, Outcome::slave_error);
  EXPECT_EQ(unknown.error, cansync::ParameterError::not_present);
  std::vector<std::uint8_t> data(8);
  EXPECT_EQ(net.end_of(net.transfer(2, true, data)).error, cansync::TransferError::not_possible);
  EXPECT_EQ(net.cluster().gateway().counters().unknown, 2u);
}

TEST(Cluster, K3TheTableIsChecked) {
  Levels net;
  EXPECT_TRUE(check(net.a.cluster).empty());
  auto settings = net.a.cluster;
  settings.gateway.routes = {Levels::route(0, 0, 0), Levels::route(1, 0, 0), Levels::route(9, 0, 0),
                             Levels::route(9, 1, 0), Levels::route(10, 30, 0)};
  settings.lower.bit_rate = BitRate::kbit125;
  settings.gateway.monitoring = std::chrono::seconds(9);
  std::vector<std::string> fields;
  for (const auto& problem : check(settings)) fields.push_back(problem.field);
  EXPECT_EQ(fields, (std::vector<std::string>{"lower.bit_rate", "gateway.routes[0].number",
                                              "gateway.routes[1].number", "gateway.routes[3].number",
                                              "gateway.routes[4].slave", "gateway.monitoring"}));
}

/// Every interval of a slave's SYNC is the nominal one, but for the greatest step.
void expect_no_jump(const std::vector<can::Time>& edges, can::Time interval, can::Time step) {
  for (std::size_t i = 1; i < edges.size(); ++i) {
    const can::Time difference = edges[i] - edges[i - 1] - interval;
    ASSERT_LE(std::abs(difference.count()), step.count()) << "edge " << i << " at " << edges[i].count();
  }
}

TEST(Cluster, K4SyncReachesEveryLevelInEveryInterval) {
  Levels net(BitRate::mbit1, 8, 3);
  net.start();
  const std::size_t before = net.lowest[0]->edges.size();
  const auto made = net.top_bus->counters().sync_edges;
  net.run(500);
  EXPECT_EQ(net.top_bus->counters().sync_edges - made, 500u);
  EXPECT_EQ(net.lowest[0]->edges.size() - before, 500u);
  // They are in time with those of the first master.
  for (std::size_t i = before; i < net.lowest[0]->edges.size(); ++i) {
    const auto phase = net.lowest[0]->edges[i].count() % net.times.interval.count();
    EXPECT_EQ(std::min(phase, net.times.interval.count() - phase), 0) << i;
  }
}

TEST_P(ClusterAcceptance, K5TheLowerSyncIsPhaseLockedAndDoesNotJump) {
  Levels net(GetParam());
  net.a.phase = net.times.interval / 3;
  net.a.greatest_step = net.times.interval / 1000;
  net.build();
  net.run(200);
  EXPECT_TRUE(net.middle[0]->edges.empty()) << "no SYNC below before the one above is followed";
  ASSERT_TRUE(net.run_until([&] { return net.cluster().state() == ClusterState::active; }, 3000));
  net.run(200);
  expect_no_jump(net.middle[0]->edges, net.times.interval, net.a.greatest_step);
  const auto phase = net.gateway_a->lock().phase_error();
  EXPECT_LT(std::abs(phase.count()), 1000);
}

TEST(Cluster, K4ThreeLevelsComeIntoPhaseOneAfterTheOther) {
  Levels net(BitRate::mbit1, 8, 3);
  net.a.phase = net.times.interval / 3;
  net.b.phase = net.times.interval / 4;
  net.build();
  ASSERT_TRUE(net.run_until([&] { return net.all_active(); }, 4000));
  net.run(300);
  expect_no_jump(net.middle[0]->edges, net.times.interval, net.a.greatest_step);
  expect_no_jump(net.lowest[0]->edges, net.times.interval, net.b.greatest_step);
  const auto half = net.times.interval / 2;
  const can::Time phase = (net.lowest[0]->edges.back() + half) % net.times.interval - half;
  EXPECT_LT(std::abs(phase.count()), 1000) << "of the first master's edges, through both gateways";
}

TEST(Cluster, K5AnEdgeThatIsMissingAboveIsMadeBelow) {
  Levels net;
  net.start();
  const std::size_t before = net.middle[0]->edges.size();
  Fault fault;
  fault.kind = FaultKind::missing_sync;
  fault.node = NodeNumber{kGatewayA};
  fault.from = net.top_bus->intervals() + 10;
  fault.to = fault.from + 20;
  net.top_bus->faults().add(fault);
  net.run(100);
  EXPECT_EQ(net.middle[0]->edges.size() - before, 100u);
  expect_no_jump(net.middle[0]->edges, net.times.interval, net.a.greatest_step);
  EXPECT_EQ(net.cluster().state(), ClusterState::active);
  EXPECT_EQ(net.cluster().sync_losses(), 0u);
}

TEST(Cluster, K5WithTheUpperSyncLostTheLowerIsStoppedAndBeginsAgainAfterwards) {
  Levels net;
  net.start();
  Fault fault;
  fault.kind = FaultKind::missing_sync;
  fault.node = NodeNumber{kGatewayA};
  fault.from = net.top_bus->intervals() + 1;
  fault.to = fault.from + 300;
  net.top_bus->faults().add(fault);
  const auto open = net.read(kMiddle + 1, 20);
  net.middle[1]->busy = [] { return 100'000u; };
  ASSERT_EQ(net.upper_master().submit(open), cansync::Refusal::none);
  net.run(90);
  EXPECT_EQ(net.cluster().state(), ClusterState::active) << "holdover";
  net.run(60);
  EXPECT_EQ(net.cluster().state(), ClusterState::waiting_for_sync);
  EXPECT_EQ(net.cluster().sync_losses(), 1u);
  EXPECT_FALSE(net.cluster().sync_output());
  const std::size_t stopped = net.middle[0]->edges.size();
  net.run(100);
  EXPECT_EQ(net.middle[0]->edges.size(), stopped);
  net.middle[1]->busy = [] { return 0u; };
  EXPECT_TRUE(net.run_until([&] { return net.all_active(); }, 1000));
  EXPECT_TRUE(net.run_until([&] { return net.ends.parameters.contains(open.id); }, 4000));
  EXPECT_EQ(net.end_of(net.read(kMiddle + 1, 22)).value, LeafSlave::initial(kMiddle + 1, 22));
}

TEST(Cluster, K6TheSlaveIsStartedFirstAndTheMasterWaitsForTheLockOfIts) {
  Levels net;
  net.build();
  EXPECT_EQ(net.cluster().upper().state(), State::active_slave);
  EXPECT_EQ(net.cluster().lower().state(), State::waiting_for_start);
  EXPECT_EQ(net.cluster().state(), ClusterState::waiting_for_sync);
  ASSERT_TRUE(net.run_until([&] { return net.cluster().sync_output(); }, 500));
  EXPECT_EQ(net.gateway_a->lock().state(), sync_line::LockState::locked);
  EXPECT_EQ(net.cluster().state(), ClusterState::setting_up);
  ASSERT_TRUE(net.run_until([&] { return net.all_active(); }, 4000));
  net.cluster().stop();
  EXPECT_EQ(net.cluster().upper().state(), State::start_up);
  EXPECT_EQ(net.cluster().lower().state(), State::start_up);
  EXPECT_EQ(net.cluster().state(), ClusterState::stopped);
  net.cluster().start();
  EXPECT_TRUE(net.run_until([&] { return net.all_active(); }, 4000));
  EXPECT_EQ(net.end_of(net.read(kMiddle + 1, 22)).value, LeafSlave::initial(kMiddle + 1, 22));
}

TEST(Cluster, K7WhoIsEnabledIsASetting) {
  Levels net;
  net.a.cluster.enable_upper = false;
  net.a.cluster.enable_lower = false;
  net.build();
  net.run(400);
  EXPECT_EQ(net.cluster().upper().state(), State::setting_up_slave);
  EXPECT_EQ(net.cluster().lower().state(), State::setting_up_master);
  EXPECT_EQ(net.cluster().state(), ClusterState::setting_up);
  // Parameters cross all the same.
  EXPECT_EQ(net.end_of(net.read(kMiddle + 1, 21)).value, LeafSlave::initial(kMiddle + 1, 21));
}

// --- lead axis

using Kind = LeadSource::Kind;

LeadSource reference_source(std::uint8_t value) {
  return {LeadSource::Kind::reference, value, {}, true};
}

/// What a slave below got in each interval, against the ramp of the first master.
void expect_ramp(Levels& net, std::size_t from, unsigned channel, unsigned value, std::uint32_t offset,
                 unsigned delay) {
  std::size_t seen = 0;
  for (std::size_t i = from; i < net.middle[0]->references.size(); ++i) {
    const auto& reference = net.middle[0]->references[i];
    ASSERT_TRUE(reference.fresh[channel]) << i;
    const auto interval = static_cast<std::uint32_t>(reference.at / net.times.interval);
    ASSERT_EQ(reference.values[value], offset + interval - delay) << i;
    ++seen;
  }
  EXPECT_GT(seen, 90u);
}

TEST_P(ClusterAcceptance, K8TheSlavesPartGoesBeforeTheMastersSoThatAValueGoesDownInItsInterval) {
  Levels net(GetParam());
  net.a.cluster.lead[4] = reference_source(0);
  net.start();
  const std::size_t from = net.middle[0]->references.size();
  net.run(100);
  expect_ramp(net, from, 1, 4, 1000, 0);
}

TEST_P(ClusterAcceptance, K9ReferenceValuesGoDownInTheIntervalThatTheCheckNames) {
  Levels net(GetParam());
  net.a.cluster.lead[0] = reference_source(0);
  net.a.cluster.lead[4] = reference_source(0);
  net.a.cluster.lead[5] = reference_source(4);
  ASSERT_TRUE(check(net.a.cluster).empty());
  EXPECT_EQ(describe_lead_axis(net.a.cluster),
            (std::vector<std::string>{"reference value 0 of the upper bus becomes reference value 0 of the "
                                      "lower bus in the next interval",
                                      "reference value 0 of the upper bus becomes reference value 4 of the "
                                      "lower bus in the same interval",
                                      "reference value 4 of the upper bus becomes reference value 5 of the "
                                      "lower bus in the next interval"}));
  net.start();
  const std::size_t from = net.middle[0]->references.size();
  net.run(100);
  expect_ramp(net, from, 0, 0, 1000, 1);
  expect_ramp(net, from, 1, 4, 1000, 0);
  expect_ramp(net, from, 1, 5, 500'000, 1);
}

TEST(Cluster, K9AValueThatDidNotComeIsLeftOutAndNoOlderOneTakesItsPlace) {
  Levels net;
  net.a.cluster.lead[0] = reference_source(0);
  net.a.cluster.lead[4] = reference_source(0);
  net.start();
  const std::size_t from = net.middle[0]->references.size();
  Fault fault;
  fault.kind = FaultKind::lost;
  fault.identifier = 0x100;
  fault.mask = cansync::identifier::channel_bits;
  fault.probability = 0.4;
  fault.to = net.top_bus->intervals() + 199;
  net.top_bus->faults().add(fault);
  net.run(202);
  std::array<unsigned, 2> missing = {};
  for (std::size_t i = from; i < net.middle[0]->references.size(); ++i) {
    const auto& reference = net.middle[0]->references[i];
    const auto interval = static_cast<std::uint32_t>(reference.at / net.times.interval);
    for (const unsigned channel : {0u, 1u}) {
      if (!reference.fresh[channel]) {
        ++missing[channel];
      } else {
        ASSERT_EQ(reference.values[channel * 4], 1000 + interval - (channel == 0 ? 1 : 0));
      }
    }
  }
  EXPECT_GT(missing[0], 50u);
  EXPECT_EQ(missing[0], missing[1]);
  EXPECT_GE(net.cluster().lead().counters(Channel::one).missing, missing[0]);
}

TEST(Cluster, K9ActualValuesOfTheGatewayAndOfItsNeighboursGoDown) {
  Levels net;
  cansync::SlaveSideSettings neighbour;
  neighbour.number = *SlaveNumber::from(2);
  net.beside.emplace_back(std::uint16_t{4242}, neighbour);
  net.master.master.slaves[2].configured = true;
  net.master.master.process.polling[0] = {cansync::Cursor::Kind::fixed, *SlaveNumber::from(2)};
  net.a.cluster.upper.monitored[2] =
      cansync::ProcessMapping{cansync::default_mapping(Channel::one), cansync::default_mapping(Channel::two)};
  net.a.cluster.lead[0] = {LeadSource::Kind::monitored, 0, *SlaveNumber::from(2), true};
  net.a.cluster.lead[4] = {LeadSource::Kind::actual, 3, {}, true};
  EXPECT_EQ(describe_lead_axis(net.a.cluster),
            (std::vector<std::string>{"actual value 0 of slave 2 of the upper bus becomes reference value 0 "
                                      "of the lower bus in the next interval",
                                      "actual value 3 of the gateway itself becomes reference value 4 of the "
                                      "lower bus in the same interval"}));
  net.build();
  std::uint32_t position = 0;
  net.gateway_a->on_interval = [&](ClusterNode& node) {
    cansync::Values values = {};
    values[3] = ++position + 7000;
    node.cluster().release_actual(Channel::one, values);
  };
  ASSERT_TRUE(net.run_until([&] { return net.all_active(); }, 4000));
  net.run(10);
  const auto& last = net.middle[0]->references.back();
  EXPECT_EQ(last.values[0], 4242u);
  EXPECT_TRUE(last.fresh[0]);
  EXPECT_EQ(last.values[4], position + 7000 - 1) << "of the interval before the one that has just begun";
}

TEST_P(ClusterAcceptance, K9WhichIntervalItIsFollowsFromTheManualsTimes) {
  using namespace cansync;
  const SlotTimes& times = slot_times(GetParam());
  for (const Kind kind : {Kind::reference, Kind::actual, Kind::monitored}) {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}}) {
      for (const Channel lower : {Channel::one, Channel::two}) {
        const bool same =
            kind == Kind::actual || (kind == Kind::reference && value == 0 && lower == Channel::two);
        EXPECT_EQ(lead_delay({kind, value, {}, true}, lower, times, default_send_margin(GetParam()),
                             microseconds(50)),
                  same ? 0u : 1u);
      }
    }
  }
  // With too little time between, also that one goes in the next interval.
  EXPECT_EQ(lead_delay({Kind::reference, 0, {}, true}, Channel::two, times, default_send_margin(GetParam()),
                       times.interval / 3),
            1u);
}

TEST(Cluster, K9TheCheckFindsWhatCannotBeCopied) {
  Levels net;
  auto settings = net.a.cluster;
  settings.lead[0] = reference_source(7);                         // no telegram brings it
  settings.lead[3] = reference_source(0);                         // the lower mapping does not carry it
  settings.lead[4] = {LeadSource::Kind::monitored, 0, {}, true};  // nobody listens
  settings.lead[5] = reference_source(8);
  std::vector<std::string> fields;
  for (const auto& problem : check(settings)) fields.push_back(problem.field);
  EXPECT_EQ(fields, (std::vector<std::string>{"lead[0]", "lead[3]", "lead[4]", "lead[5]"}));
}

TEST(Cluster, K14ActionsProcessDataAndStatusDoNotCross) {
  Levels net;
  net.start();
  cansync::ControlWordRequest word;
  word.id = 1;
  word.slave = *SlaveNumber::from(kGatewayA);
  word.control_word = 0x1234;
  ASSERT_EQ(net.upper_master().submit(word), cansync::Refusal::none);
  cansync::BroadcastRequest all;
  all.id = 2;
  all.action = {cansync::SlaveMask::all(), 1, 0, 0x4321};
  ASSERT_EQ(net.upper_master().submit(all), cansync::Refusal::none);
  net.run(20);
  EXPECT_EQ(net.told_a.words.size(), 2u);
  for (const LeafSlave* slave : net.middle) {
    EXPECT_TRUE(slave->control_words.empty());
    EXPECT_FALSE(slave->references.back().fresh[0]) << "nothing is copied that no table names";
  }
  // A slave that is lost below is lost to its own master alone.
  net.middle[1]->deaf = true;
  EXPECT_TRUE(
      net.run_until([&] { return !net.cluster().lower().slave(*SlaveNumber::from(1)).responds; }, 5000));
  EXPECT_TRUE(net.upper_master().slave(*SlaveNumber::from(kGatewayA)).responds);
}

}  // namespace
}  // namespace sim::test
