// What the realtime thread of a cluster must not do, watched in virtual time: a master above that reads and
// writes what is below, a lead axis, and an upper SYNC that is lost and comes back.
#include "cluster_rig.h"
#include "rt/alloc_counter.h"

namespace cansyncd::test {
namespace {

/// Counts what the thread does between two of its turns, and ends the loop.
class CountingBus final : public WatchedBus {
 public:
  explicit CountingBus(can::Bus& line) : WatchedBus(line) {}

  static constexpr std::uint64_t kTurns = 40'000;
  static constexpr std::uint64_t kWatched = 5000;  ///< from this turn on
  RealtimeLoop* loop = nullptr;
  std::uint64_t turns = 0;
  rt::ThreadCalls before;
  rt::ThreadCalls after;

  can::Wake wait_until(can::Time deadline) noexcept override {
    ++turns;
    if (turns == kWatched) before = rt::thread_calls();
    if (turns == kTurns) {
      after = rt::thread_calls();
      loop->request_stop();
    }
    return WatchedBus::wait_until(deadline);
  }
};

TEST(RealtimeRules, TheLoopOfAClusterNeitherAllocatesNorLocksNorWritesAnythingButItsWakeSignals) {
  ClusterRig rig;
  rig.traced = false;
  for (const bool write : {false, true}) {
    cansync::ParameterRequest request;
    request.id = write ? 2 : 1;
    request.slave = *cansync::SlaveNumber::from(kNumber);
    request.sub_slave = {kDriveNumber};
    request.number = *cansync::ParameterNumber::from(300);
    request.write = write;
    request.value = 9;
    rig.master_settings.routines.push_back({write ? 25u : 0u, 50, request});
  }
  sim::Fault away;
  away.kind = sim::FaultKind::missing_sync;
  away.from = 2500;
  away.to = 2600;
  rig.upper_line_settings.faults = {away};
  CountingBus* bus = nullptr;
  rig.make_bus = [&](can::Bus& line) {
    auto made = std::make_unique<CountingBus>(line);
    bus = made.get();
    return made;
  };
  rig.build();
  bus->loop = rig.loop.get();
  rig.both->begin();
  rig.loop->run();
  rig.both->end();

  EXPECT_EQ(rig.cluster->sync_losses(), 1u);
  EXPECT_GT(rig.cluster->gateway().counters().parameters, 100u);
  EXPECT_GT(rig.cluster->lead().counters(cansync::Channel::two).given, 1000u);
  ASSERT_TRUE(rig.asker.results[1] && rig.asker.results[2]);
  EXPECT_EQ(bus->after.allocations, bus->before.allocations);
  EXPECT_EQ(bus->after.locks, bus->before.locks);
  // Nobody takes the signals, so that each is given once, before the turns that are watched.
  EXPECT_EQ(bus->after.writes, bus->before.writes);
}

}  // namespace
}  // namespace cansyncd::test
