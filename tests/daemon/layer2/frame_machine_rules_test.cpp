// What the realtime thread of a bus of general frames must not do, watched in virtual time on a busy bus.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "can/flagged_frames.h"
#include "daemon/layer2/realtime/frame_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/flight_tap.h"
#include "layer2/sim/frame_node.h"
#include "rt/flight_recorder.h"
#include "sim/line.h"
#include "support/watched_turns.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using std::chrono::milliseconds;

/// Plays the gateway between two turns of the loop: orders, takes back, reads everything.
class BusyBus final : public test::WatchedTurns {
 public:
  BusyBus(can::Bus& line, Layer2Exchange& exchange) : WatchedTurns(line, 10, 5000), exchange_(exchange) {
    prepared_.parts = {true, true, true, true, true, true, true};
  }

  std::uint64_t answers = 0;
  std::uint64_t frames = 0;
  std::uint64_t sequences = 0;   ///< orders of several frames, all of which were sent
  std::uint64_t configured = 0;  ///< other settings were taken over

  // Now and then the bus takes nothing.
  can::SendResult send(const can::Frame& frame) noexcept override {
    return turns % 50 < 5 ? can::SendResult::queue_full : behind_.send(frame);
  }

 private:
  void work() noexcept override {
    ++number_;
    exchange_.requests.try_push(
        layer2::SendOrder{number_, {.id = static_cast<std::uint32_t>(number_ % 0x800)}, milliseconds(2)});
    if (number_ % 7 == 0) exchange_.requests.try_push(CancelOrder{number_});
    if (number_ % 20 == 3) {
      number_ += 2;
      exchange_.requests.try_push(layer2::SendOrder{
          .id = number_, .frame = following_[0], .timeout = milliseconds(20), .following = following_});
      // What it takes over it gives back the next time.
      exchange_.requests.try_push(layer2::ControlOrder{
          .id = number_ - 1, .what = layer2::Control::configure, .prepared = &prepared_});
      outputs_.table = static_cast<std::uint32_t>(configured);
      outputs_.sending = true;
      outputs_.bytes[0] = static_cast<std::uint8_t>(number_);
      exchange_.outputs.write(outputs_);
    }
    SendDone done;
    while (exchange_.done.try_pop(done)) {
      ++answers;
      if (done.refusal == layer2::Refusal::none && done.answer.seen == 1 + following_.size()) ++sequences;
      if (done.refusal == layer2::Refusal::none && done.answer.id % 20 == 4) ++configured;
    }
    ReceivedReport report;
    while (exchange_.frames.try_pop(report)) ++frames;
  }

  static layer2::ModuleSettings other_settings() {
    layer2::ModuleSettings settings;
    settings.station.filter.add({0, 0x3FF, false, layer2::FrameKinds::data_and_remote});
    settings.station.queue = 30;
    settings.timers[4] = layer2::TimerSettings{.frame = data_frame(0x70, {1})};
    settings.mapped = {{.identifier = 0x310, .address = 0, .size = 8, .output = true}};
    settings.mapping.rule = {.identifier = 0x310, .mask = 0x7FF};
    settings.mapping.interval = milliseconds(10);
    return settings;
  }

  Layer2Exchange& exchange_;
  std::uint64_t number_ = 0;
  const std::array<can::Frame, 3> following_ = {data_frame(0x1, {1}), data_frame(0x2, {}),
                                                data_frame(0x3, {})};
  layer2::PreparedSettings prepared_{other_settings()};
  OutputImage outputs_;
};

TEST(RealtimeRules, TheLoopOfGeneralFramesNeitherAllocatesNorLocksNorWritesAnythingButItsWakeSignal) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::FrameNode>(
      sim::FrameNodeSettings{.periodic = data_frame(0x100, {0, 1, 2}), .period = milliseconds(1)}));
  sim::Line line({}, std::move(nodes));
  Layer2Exchange exchange(64, 64);
  BusyBus busy(line, exchange);
  rt::FlightRecorder recorder(4096, 10);
  FlightTap tap(recorder, {});
  RecordedBus recorded(busy, tap);
  FrameMachineSettings settings;
  settings.tap = &tap;
  settings.module.station.filter.add({0, 0x7FF, false, layer2::FrameKinds::data_and_remote});
  FrameMachine machine(settings, recorded, exchange);

  DeadlineLoop<FrameMachine> loop(machine, recorded);
  busy.end = [&loop] { loop.request_stop(); };
  loop.run();

  EXPECT_GT(busy.answers, 1000u);
  EXPECT_GT(busy.frames, 100u);
  EXPECT_GT(busy.sequences, 10u);
  EXPECT_GT(busy.configured, 10u);
  EXPECT_EQ(busy.after.allocations, busy.before.allocations);
  EXPECT_EQ(busy.after.locks, busy.before.locks);
  // Nobody takes the signal, so that it is given once, before the turns that are watched.
  EXPECT_EQ(busy.after.writes, busy.before.writes);
}

}  // namespace
}  // namespace cansyncd
