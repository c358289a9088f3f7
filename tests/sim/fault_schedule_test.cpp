// Which frames a fault hits, and that a seed gives the same course each time.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "cansync/sim/drive_faults.h"
#include "node_list.h"
#include "sim/faults.h"
#include "sim/line.h"

namespace {

using namespace sim::test;
using can::Time;
using sim::Fault;
using sim::FaultKind;
using sim::Line;

TEST(Faults, SlaveFilterKnowsTheChannelsThatNameASlave) {
  const std::vector<std::pair<std::string_view, bool>> cases = {
      {"105#", true},  {"185#", true},       {"305#", true},  {"385#", true},
      {"505#", true},  {"585#", true},       {"005#", false}, {"205#", false},
      {"285#", false}, {"00000305#", false}, {"106#", false}, {"405#", false}};
  for (const auto& [what, expected] : cases) {
    sim::FaultSchedule faults({{.kind = FaultKind::corrupted, .node = 5}}, 1, &sim::drive_faults());
    EXPECT_EQ(faults.at_start(frame(what), false).corrupted, expected) << what;
  }
}

TEST(Faults, ProbabilityHitsAsOftenAsItSays) {
  sim::FaultSchedule faults({{.kind = FaultKind::lost, .probability = 0.25},
                             {.kind = FaultKind::lost, .probability = 0},
                             {.kind = FaultKind::lost, .probability = 1}},
                            7);
  for (int n = 0; n < 10'000; ++n) faults.at_start(frame("101#"), false);
  EXPECT_NEAR(static_cast<double>(faults.hits(0)), 2500, 200);
  EXPECT_EQ(faults.hits(1), 0u);
  EXPECT_EQ(faults.hits(2), 10'000u);
  EXPECT_EQ(faults.hits(3), 0u) << "no such fault";
}

TEST(Faults, AddedFaultDoesNotChangeWhenTheOthersHit) {
  const Fault random{.kind = FaultKind::corrupted, .probability = 0.5};
  sim::FaultSchedule alone({random}, 9);
  sim::FaultSchedule together({random, {.kind = FaultKind::lost, .probability = 0.5}}, 9);
  for (int n = 0; n < 200; ++n) {
    EXPECT_EQ(alone.at_start(frame("101#"), false).corrupted,
              together.at_start(frame("101#"), false).corrupted);
  }
}

TEST(Faults, AnotherFaultInItsPlaceCountsAnew) {
  sim::FaultSchedule faults({{.kind = FaultKind::lost}, {.kind = FaultKind::corrupted, .count = 0}}, 1);
  EXPECT_TRUE(faults.at_start(frame("101#"), false).lost_to_master);
  faults.replace(0, {.kind = FaultKind::corrupted, .count = 2});
  EXPECT_EQ(faults.hits(0), 0u);
  const auto fate = faults.at_start(frame("101#"), false);
  EXPECT_TRUE(fate.corrupted);
  EXPECT_FALSE(fate.lost_to_master);
  EXPECT_EQ(faults.hits(0), 1u);
  faults.replace(2, {.kind = FaultKind::lost});
  EXPECT_EQ(faults.size(), 2u) << "no such fault";
}

// --- determinism

// A node that answers every frame of the master a while later.
class EchoingNode final : public sim::Node {
 public:
  explicit EchoingNode(unsigned number) : number_(static_cast<sim::NodeNumber>(number)) {}
  sim::NodeNumber node_number() const noexcept override { return number_; }
  bool accepts(const can::Frame& frame) const noexcept override { return (frame.id & 0x780) == 0x100; }
  void on_sync(Time) noexcept override {}
  std::optional<sim::Transmission> on_frame(const can::Frame& received, Time end) noexcept override {
    can::Frame answer = received;
    answer.id = 0x300u + number_;
    return sim::Transmission{answer, end + us(10 + number_ % 3)};
  }

 private:
  sim::NodeNumber number_;
};

Texts course(std::uint64_t seed, const std::vector<Fault>& faults) {
  RecordingTrace trace;
  Nodes nodes;
  for (unsigned n = 0; n < 8; ++n) add<EchoingNode>(nodes, n);
  Line line({.seed = seed, .faults = faults, .trace = &trace}, std::move(nodes));
  for (int interval = 0; interval < 200; ++interval) {
    line.sync_edge(us(2000 * interval));
    line.send(frame("101#00FF00FF00FF00FF"));
    run_until(line, us(2000 * interval + 2000));
  }
  return trace.lines;
}

TEST(Determinism, SameSeedGivesTheSameCourse) {
  const std::vector<Fault> faults = {{.kind = FaultKind::corrupted, .probability = 0.05},
                                     {.kind = FaultKind::lost, .probability = 0.1},
                                     {.kind = FaultKind::late, .probability = 0.2, .delay = us(37)},
                                     {.kind = FaultKind::duplicated, .probability = 0.03},
                                     {.kind = FaultKind::missing_sync, .probability = 0.05}};
  const Texts first = course(42, faults);
  EXPECT_EQ(first, course(42, faults));
  EXPECT_NE(first, course(43, faults));
  EXPECT_GT(first.size(), 1500u);
}

TEST(Determinism, WithoutChanceTheSeedDoesNotMatter) {
  EXPECT_EQ(course(1, {}), course(2, {}));
}

}  // namespace
