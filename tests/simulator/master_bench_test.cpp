// The simulated master of `cansync-sim --master` in virtual time, with simulated drives on the other end.

#include "simulator/master_bench.h"

#include <gtest/gtest.h>

#include "rig.h"
#include "simulator/run.h"

namespace {

using namespace std::chrono_literals;
using cansync_sim::Bench;
using cansync_sim::MasterBench;

sim::MasterNodeSettings master_settings() {
  sim::MasterNodeSettings settings;
  settings.master.bit_rate = cansync::BitRate::kbit500;
  settings.master.send_margin = cansync::default_send_margin(settings.master.bit_rate);
  settings.master.process.maximum_slave = *cansync::SlaveNumber::from(3);
  settings.master.slaves[3].configured = true;
  settings.references[0] = {sim::ReferenceCurve::Kind::ramp, 1000, 7};
  return settings;
}

/// Both ends on one wire. A frame is on it for 250 us; each end is woken `late` after what it asked for.
class Wire {
 public:
  Wire() : master_(master_settings(), 0x080, [this](const std::string& line) { said.push_back(line); }) {}

  void run_until(can::Time end, can::Time late = 0us) {
    while (now_ < end) {
      now_ = std::max(now_ + 1us, std::min({end, master_.next_due() + late, drives_.next_due(), arrival()}));
      deliver();
      while (const auto frame = master_.next(now_)) put(*frame, master_, drives_);
      while (const auto frame = drives_.next(now_)) put(*frame, drives_, master_);
    }
  }

  MasterBench& master() { return master_; }
  const sim::Drive& drive() { return *drives_.drives()[0]; }
  std::vector<std::string> said;
  std::vector<can::Time> edges;
  std::uint64_t telegrams = 0;  ///< of the master

 private:
  struct Flying {
    can::ReceivedFrame frame;
    cansync_sim::Station* to;
  };

  void put(const can::Frame& frame, cansync_sim::Station& from, cansync_sim::Station& to) {
    from.sent(can::SendResult::queued);
    if (frame.id == 0x080) edges.push_back(now_);
    if (&from == &master_ && frame.id != 0x080) ++telegrams;
    flying_.push_back({{frame, now_ + 250us, false}, &to});
  }
  can::Time arrival() const { return flying_.empty() ? can::Time::max() : flying_.front().frame.end; }
  void deliver() {
    while (arrival() <= now_) {
      const Flying arrived = flying_.front();
      flying_.pop_front();
      arrived.to->receive(arrived.frame, now_);
    }
  }

  can::Time now_ = 1s;
  MasterBench master_;
  Bench drives_{bench_settings(), drives({3})};
  std::deque<Flying> flying_;
};

TEST(MasterBench, BringsADriveToActiveOperationAndLetsItFollow) {
  Wire wire;
  wire.run_until(2s);
  EXPECT_EQ(wire.said,
            (std::vector<std::string>{"state: waiting for initialisation data", "state: stop", "state: setup",
                                      "slave 3: starting", "slave 3: released", "state: run"}));
  EXPECT_EQ(wire.master().counters().syncs, 500u);
  EXPECT_EQ(wire.drive().slave().references()[0], 1000u + 7u * 499u);
  EXPECT_EQ(wire.drive().fault(), 0);
  EXPECT_EQ(wire.master().master().counters().left_out, 0u);
}

TEST(MasterBench, KeepsTheTimeOfTheLineWhenItIsWokenLate) {
  Wire wire;
  wire.run_until(1100ms, 30us);
  ASSERT_EQ(wire.edges.size(), 50u);
  // The first one is made at once; every later one 30 us after its time, and none later than that.
  for (std::size_t n = 1; n < wire.edges.size(); ++n)
    EXPECT_EQ(wire.edges[n] - wire.edges[0], n * 2ms + 30us) << n;
}

TEST(MasterBench, LeavesOutWhatWouldStartAfterItsSlot) {
  Wire wire;
  wire.run_until(2s);
  const std::uint64_t left_out = wire.master().master().counters().left_out;
  const std::uint64_t telegrams = wire.telegrams;
  const std::size_t edges = wire.edges.size();
  // Edges half an interval late; each telegram of the master would be as late again.
  wire.run_until(2100ms, 1ms);
  EXPECT_EQ(wire.telegrams, telegrams);
  EXPECT_GT(wire.master().master().counters().left_out, left_out);
  ASSERT_GT(wire.edges.size(), edges + 20);
  for (std::size_t n = 1; n < wire.edges.size(); ++n)
    ASSERT_GE(wire.edges[n] - wire.edges[n - 1], 1ms) << "never two edges close together";
}

TEST(MasterBench, MakesNoEdgeThatIsMoreThanHalfAnIntervalLate) {
  Wire wire;
  wire.run_until(2s);
  const std::size_t edges = wire.edges.size();
  wire.run_until(2100ms, 1001us);
  EXPECT_LE(wire.edges.size(), edges + 1);
  wire.run_until(2200ms);
  EXPECT_GT(wire.edges.size(), edges + 40);
  EXPECT_EQ((wire.edges.back() - wire.edges.front()) % 2ms, can::Time{0}) << "the line has kept its time";
}

TEST(MasterBench, CountsWhatTheInterfaceDoesNotTake) {
  MasterBench bench(master_settings(), 0x080, {});
  ASSERT_TRUE(bench.next(1s));
  bench.sent(can::SendResult::queue_full);
  EXPECT_EQ(bench.counters().not_sent, 1u);
  EXPECT_EQ(bench.counters().syncs, 0u);
  EXPECT_NE(cansync_sim::summary(bench, 4).find("0 SYNC, 0 frames received, 0 sent, 1 not sent"),
            std::string::npos);
}

TEST(MasterBench, RunsOnAPortFromTheFirstMomentOn) {
  ScriptedPort port;
  port.stops(9ms);
  MasterBench bench(master_settings(), 0x080, {});
  cansync_sim::run(bench, port, {"vcan7", [](const std::string&) {}});
  ASSERT_FALSE(port.sent().empty());
  EXPECT_EQ(port.sent().front(), (ScriptedPort::Sent{0ms, "080#"}));
  EXPECT_EQ(bench.counters().syncs, 5u);
}

}  // namespace
