// The lower SYNC behind an upper one that jitters, drifts, jumps and stays away. Rows of
// docs/cansync-cluster.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::ClusterState;
using std::chrono::microseconds;
using std::chrono::nanoseconds;
using sync_line::LockState;

/// A gateway alone: the test makes the upper edges wherever it likes.
class GatewayAlone {
 public:
  GatewayAlone() {
    Levels plan;
    settings_ = plan.a;
    settings_.cluster.lead[4] = {cansync::LeadSource::Kind::reference, 0, {}, true};
    LineSettings line;
    std::vector<std::unique_ptr<Node>> nodes;
    for (unsigned n = 0; n < 3; ++n) {
      cansync::SlaveSideSettings slave;
      slave.number = *SlaveNumber::from(n);
      auto leaf =
          std::make_unique<LeafSlave>(slave, static_cast<std::uint16_t>(kMiddle + n), microseconds(20));
      slaves_.push_back(leaf.get());
      nodes.push_back(std::move(leaf));
    }
    lower_ = std::make_unique<Line>(line, std::move(nodes));
    node_ = std::make_unique<ClusterNode>(settings_, nobody_, ends_);
    node_->connect(*lower_);
  }

  /// Lets the timeline run up to `at`, where the upper edge stands.
  void edge(can::Time at) {
    until(at);
    node_->on_sync(at);
    at_ = at;
  }
  void until(can::Time at) {
    while (node_->next_instant() && *node_->next_instant() <= at) {
      node_->advance_lower(*node_->next_instant());
      node_->act();
    }
  }
  /// WRC1 of the upper bus, 100 us after its edge.
  void reference(std::uint16_t word) {
    until(at_ + microseconds(100));
    cansync::ReferenceTelegram telegram;
    telegram.word[0] = word;
    static_cast<void>(node_->on_frame(encode(telegram), at_ + microseconds(100)));
  }
  const std::vector<can::Time>& edges() const { return slaves_[0]->edges; }
  ClusterNode& node() { return *node_; }
  std::uint64_t given() const { return node_->cluster().lead().counters(Channel::two).given; }

  /// The greatest deviation of an interval below from the nominal one, since edge `from`.
  can::Time greatest(std::size_t from = 1) const {
    can::Time most{};
    for (std::size_t i = std::max<std::size_t>(from, 1); i < edges().size(); ++i)
      most = std::max(most, can::Time(std::abs((edges()[i] - edges()[i - 1] - kInterval).count())));
    return most;
  }
  static constexpr can::Time kInterval = std::chrono::milliseconds(1);

 private:
  ClusterNodeSettings settings_;
  NobodyTold nobody_;
  JobEnds ends_;
  std::vector<LeafSlave*> slaves_;
  std::unique_ptr<Line> lower_;
  std::unique_ptr<ClusterNode> node_;
  can::Time at_{};
};

TEST(ClusterSync, K5EdgesThatJitterAreSmoothedBelow) {
  GatewayAlone gateway;
  std::mt19937_64 dice(4);
  for (int k = 1; k < 3000; ++k)
    gateway.edge(GatewayAlone::kInterval * k + microseconds(static_cast<int>(dice() % 51) - 25));
  EXPECT_EQ(gateway.node().cluster().state(), ClusterState::active);
  EXPECT_GT(gateway.edges().size(), 2500u);
  EXPECT_LE(gateway.greatest(), microseconds(1)) << "the greatest step, of edges that are 25 us off";
  const auto phase =
      (gateway.edges().back() + microseconds(500)) % GatewayAlone::kInterval - microseconds(500);
  EXPECT_LT(std::abs(phase.count()), nanoseconds(microseconds(15)).count());
}

TEST(ClusterSync, K5AnUpperSyncThatIsFasterIsFollowed) {
  GatewayAlone gateway;
  can::Time at{};
  for (int k = 1; k < 3000; ++k) {
    at += GatewayAlone::kInterval - nanoseconds(100);
    gateway.edge(at);
  }
  EXPECT_EQ(gateway.node().cluster().state(), ClusterState::active);
  EXPECT_LE(gateway.greatest(), microseconds(1));
  EXPECT_LT(std::abs((gateway.edges().back() - at).count()), microseconds(2) / nanoseconds(1));
}

TEST(ClusterSync, K5AnUpperSyncThatJumpsIsApproachedAndTheLeadAxisStandsStillMeanwhile) {
  GatewayAlone gateway;
  int k = 1;
  std::uint16_t word = 0;
  for (; k < 500; ++k) {
    gateway.edge(GatewayAlone::kInterval * k);
    gateway.reference(++word);
  }
  ASSERT_EQ(gateway.node().cluster().state(), ClusterState::active);
  ASSERT_GT(gateway.given(), 100u);
  // Another master has taken over, half an interval off.
  bool searched = false;
  std::uint64_t given_while_searching = 0;
  for (; k < 2500; ++k) {
    gateway.edge(GatewayAlone::kInterval * k + microseconds(500));
    const bool searching = gateway.node().lock().state() == LockState::searching;
    const std::uint64_t before = gateway.given();
    gateway.reference(++word);
    gateway.until(GatewayAlone::kInterval * k + microseconds(1400));
    if (searching && gateway.node().lock().state() == LockState::searching)
      given_while_searching += gateway.given() - before;
    searched = searched || searching;
    ASSERT_TRUE(gateway.node().cluster().sync_output());
  }
  EXPECT_TRUE(searched);
  EXPECT_EQ(given_while_searching, 0u);
  EXPECT_EQ(gateway.node().lock().state(), LockState::locked);
  EXPECT_EQ(gateway.node().cluster().sync_losses(), 0u);
  EXPECT_LE(gateway.greatest(), microseconds(1)) << "SYNC below slides, and never jumps";
  const std::uint64_t before = gateway.given();
  for (; k < 2600; ++k) {
    gateway.edge(GatewayAlone::kInterval * k + microseconds(500));
    gateway.reference(++word);
  }
  EXPECT_GT(gateway.given(), before + 90);
}

TEST(ClusterSync, K5ThePhaseIsKeptOverAnUpperSyncThatWasAway) {
  GatewayAlone gateway;
  int k = 1;
  for (; k < 500; ++k) gateway.edge(GatewayAlone::kInterval * k);
  ASSERT_EQ(gateway.node().cluster().state(), ClusterState::active);
  const std::size_t before = gateway.edges().size();
  k += 400;
  gateway.until(GatewayAlone::kInterval * k);
  EXPECT_EQ(gateway.node().cluster().state(), ClusterState::waiting_for_sync);
  const std::size_t stopped = gateway.edges().size();
  EXPECT_NEAR(static_cast<double>(stopped - before), 102, 3) << "the holdover of 100 ms";
  for (; k < 1500; ++k) gateway.edge(GatewayAlone::kInterval * k);
  EXPECT_EQ(gateway.node().cluster().state(), ClusterState::active);
  EXPECT_GT(gateway.edges().size(), stopped + 400);
  const can::Time gap = gateway.edges()[stopped] - gateway.edges()[stopped - 1];
  const auto intervals = (gap + GatewayAlone::kInterval / 2) / GatewayAlone::kInterval;
  EXPECT_GT(intervals, 290);
  EXPECT_LT(std::abs((gap - GatewayAlone::kInterval * intervals).count()), 1000);
  EXPECT_LE(gateway.greatest(stopped + 1), microseconds(1));
}

}  // namespace
}  // namespace sim::test
