#include "daemon/loop/deadline_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "can/flagged_frames.h"
#include "layer2/sim/frame_node.h"
#include "sim/line.h"
#include "support/silent_bus.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using can::test::remote;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Does what the test wants at certain times, and notes what it is told.
class ScriptedMachine {
 public:
  std::multimap<can::Time, std::function<void()>> timers;
  std::deque<can::Frame> to_send;
  can::Time began{-1};
  can::Time ended{-1};
  std::vector<can::Time> advanced;
  std::vector<can::ReceivedFrame> received;
  std::vector<can::SendResult> results;
  unsigned published = 0;
  bool full = false;  ///< the controller has no place

  void begin(can::Time now) noexcept { began = now; }
  void advance(can::Time now) noexcept {
    advanced.push_back(now);
    while (!timers.empty() && timers.begin()->first <= now) {
      const auto action = timers.begin()->second;
      timers.erase(timers.begin());
      action();
    }
  }
  void receive(const can::ReceivedFrame& frame) noexcept { received.push_back(frame); }
  std::optional<can::Frame> next_frame() noexcept {
    if (to_send.empty()) return std::nullopt;
    return to_send.front();
  }
  void handed_over(can::SendResult result) noexcept {
    results.push_back(result);
    if (result == can::SendResult::queued) to_send.pop_front();
  }
  bool waits_for_echo() const noexcept { return full; }
  can::Time next_deadline() const noexcept {
    return timers.empty() ? can::Time::max() : timers.begin()->first;
  }
  void publish(can::Time) noexcept { ++published; }
  void end(can::Time now) noexcept { ended = now; }
};

/// A machine and a loop on a simulated line in virtual time.
struct Rig {
  explicit Rig(can::Time look, const sim::LineSettings& settings = {},
               std::vector<std::unique_ptr<sim::Node>> nodes = {})
      : line(settings, std::move(nodes)), loop(machine, line, look) {}
  void run_until(can::Time end) {
    machine.timers.emplace(end, [this] { loop.request_stop(); });
    loop.run();
  }
  bool advanced_at(can::Time instant) const {
    return std::find(machine.advanced.begin(), machine.advanced.end(), instant) != machine.advanced.end();
  }

  sim::Line line;
  ScriptedMachine machine;
  DeadlineLoop<ScriptedMachine> loop;
};

TEST(DeadlineLoop, LooksStandOnAnAbsoluteGrid) {
  Rig rig(milliseconds(1));
  rig.machine.timers.emplace(microseconds(2300), [] {});  // moves no look
  rig.run_until(milliseconds(5));
  const std::vector<can::Time> expected = {can::Time{0},       milliseconds(1), milliseconds(2),
                                           microseconds(2300), milliseconds(3), milliseconds(4),
                                           milliseconds(5)};
  EXPECT_EQ(rig.machine.advanced, expected);
  EXPECT_EQ(rig.loop.wake_ups(), expected.size());
}

TEST(DeadlineLoop, WakesAtTheMachinesDeadline) {
  Rig rig(milliseconds(100));
  for (const int at : {1, 250, 251, 40'000}) rig.machine.timers.emplace(microseconds(at), [] {});
  rig.run_until(milliseconds(60));
  for (const int at : {1, 250, 251, 40'000}) EXPECT_TRUE(rig.advanced_at(microseconds(at))) << at;
}

TEST(DeadlineLoop, WakesForAFrameAndHandsItOnWithItsTime) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(
      std::make_unique<sim::FrameNode>(sim::FrameNodeSettings{.answers = {data_frame(0x123, {1, 2})}}));
  Rig rig(milliseconds(100), {}, std::move(nodes));
  rig.machine.to_send = {remote(data_frame(0x123, {0, 0}))};
  rig.run_until(milliseconds(10));
  ASSERT_EQ(rig.machine.received.size(), 2u);
  EXPECT_TRUE(rig.machine.received[0].own);
  EXPECT_EQ(rig.machine.received[1].frame, data_frame(0x123, {1, 2}));
  EXPECT_TRUE(rig.advanced_at(rig.machine.received[1].end));
}

TEST(DeadlineLoop, FramesGoOutInTheOrderTheMachineGivesThem) {
  Rig rig(milliseconds(100));
  rig.machine.to_send = {data_frame(0x300, {}), data_frame(0x100, {}), data_frame(0x200, {})};
  rig.run_until(milliseconds(10));
  ASSERT_EQ(rig.machine.received.size(), 3u);
  EXPECT_EQ(rig.machine.received[0].frame.id, 0x300u);
  EXPECT_EQ(rig.machine.received[1].frame.id, 0x100u);
  EXPECT_EQ(rig.machine.received[2].frame.id, 0x200u);
}

TEST(DeadlineLoop, AFrameTheBusDoesNotTakeIsOfferedAgain) {
  sim::LineSettings settings;
  settings.transmit_queue = 1;
  Rig rig(milliseconds(1), settings);
  for (unsigned i = 0; i < 4; ++i) rig.machine.to_send.push_back(data_frame(0x100 + i, {}));
  rig.run_until(milliseconds(20));
  EXPECT_TRUE(rig.machine.to_send.empty());
  EXPECT_EQ(rig.machine.received.size(), 4u);
  EXPECT_NE(std::find(rig.machine.results.begin(), rig.machine.results.end(), can::SendResult::queue_full),
            rig.machine.results.end());
}

TEST(DeadlineLoop, ManyFramesDoNotKeepTheDeadlinesFromBeingServed) {
  sim::LineSettings settings;
  settings.transmit_queue = 4096;
  Rig rig(milliseconds(100), settings);
  for (unsigned i = 0; i < 200; ++i) rig.machine.to_send.push_back(data_frame(0x100, {}));
  rig.machine.timers.emplace(microseconds(500), [] {});
  rig.run_until(milliseconds(50));
  EXPECT_TRUE(rig.advanced_at(microseconds(500)));
  EXPECT_EQ(rig.machine.received.size(), 200u);
}

TEST(DeadlineLoop, BeginsOnceAndEndsOnce) {
  Rig rig(milliseconds(1));
  rig.run_until(milliseconds(3));
  EXPECT_EQ(rig.machine.began, can::Time{0});
  EXPECT_EQ(rig.machine.ended, milliseconds(3) + milliseconds(1));
  EXPECT_GT(rig.machine.published, 0u);
}

/// A bus that sleeps on when frames come, unless it is told to wait for one.
class SleepyBus final : public test::SilentBus {
 public:
  can::Time frame_at = can::Time::max();  ///< the echo of an own frame comes
  can::Wake wait_for_frame(can::Time deadline) noexcept override {
    if (frame_at > deadline) return wait_until(deadline);
    now_ = std::max(now_, frame_at);
    return can::Wake::frame;
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    if (frame_at > now_) return false;
    out = {data_frame(0x100, {}), std::exchange(frame_at, can::Time::max()), true};
    return true;
  }
};

TEST(DeadlineLoop, WakesForTheEchoThatMakesAPlaceOnABusThatSleepsOn) {
  for (const bool full : {false, true}) {
    SleepyBus bus;
    bus.frame_at = microseconds(130);
    ScriptedMachine machine;
    machine.full = full;
    DeadlineLoop<ScriptedMachine> loop(machine, bus, milliseconds(1));
    machine.timers.emplace(milliseconds(2), [&] { loop.request_stop(); });
    loop.run();
    ASSERT_EQ(machine.received.size(), 1u);
    std::vector<can::Time> expected = {can::Time{0}, milliseconds(1), milliseconds(2)};
    if (full) expected.insert(expected.begin() + 1, microseconds(130));
    EXPECT_EQ(machine.advanced, expected);
  }
}

/// A bus whose thread sleeps too long, once.
class LateBus final : public test::SilentBus {
 public:
  LateBus(can::Time when, can::Time until) : when_(when), until_(until) {}
  can::Wake wait_until(can::Time deadline) noexcept override {
    return SilentBus::wait_until(deadline == when_ ? until_ : deadline);
  }

 private:
  can::Time when_;
  can::Time until_;
};

TEST(DeadlineLoop, LooksThatHaveGoneByAreNotMadeUpFor) {
  LateBus bus(milliseconds(2), microseconds(7400));
  ScriptedMachine machine;
  DeadlineLoop<ScriptedMachine> loop(machine, bus, milliseconds(1));
  machine.timers.emplace(milliseconds(10), [&] { loop.request_stop(); });
  loop.run();
  const std::vector<can::Time> expected = {can::Time{0},    milliseconds(1), microseconds(7400),
                                           milliseconds(8), milliseconds(9), milliseconds(10)};
  EXPECT_EQ(machine.advanced, expected);
}

}  // namespace
}  // namespace cansyncd
