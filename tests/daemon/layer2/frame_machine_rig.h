#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "can/flagged_frames.h"
#include "daemon/layer2/realtime/frame_machine.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/flight_tap.h"
#include "layer2/sim/frame_node.h"
#include "rt/flight_recorder.h"
#include "sim/line.h"
#include "support/timed_bus.h"

/// A station on the simulated bus, in virtual time: the realtime loop with the machine on it.
namespace cansyncd::layer2_test {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using layer2::Outcome;
using std::chrono::microseconds;
using std::chrono::milliseconds;

inline constexpr can::Time kTimeout = milliseconds(100);

inline FrameMachineSettings everything() {
  FrameMachineSettings settings;
  settings.wall_clock = nullptr;
  settings.bits_per_second = 1'000'000;
  settings.module.station.filter.add({0, 0x7FF, false, layer2::FrameKinds::data_and_remote});
  settings.module.station.filter.add({0, 0x1FFFFFFF, true, layer2::FrameKinds::data_and_remote});
  return settings;
}

class ScriptedBus final : public test::TimedBus {
 public:
  using TimedBus::TimedBus;

  can::SendResult refusal = can::SendResult::queued;  ///< what `send` says instead of sending
  can::ControllerStatus status_on_top;                ///< what of the status is not the line's
  bool lose_echoes = false;                           ///< none comes
  bool can_be_reset = true;                           ///< false: as an interface that is down

  bool receive(can::ReceivedFrame& out) noexcept override {
    while (behind_.receive(out)) {
      if (!out.own || !lose_echoes) return true;
    }
    return false;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    return refusal == can::SendResult::queued ? behind_.send(frame) : refusal;
  }
  can::ResetResult reset() noexcept override {
    return can_be_reset ? TimedBus::reset() : can::ResetResult::unavailable;
  }
  can::ControllerStatus status() noexcept override {
    can::ControllerStatus status = behind_.status();
    status.unacknowledged = status_on_top.unacknowledged;
    status.dropped = status_on_top.dropped;
    status.state = status_on_top.state;
    status.link = status_on_top.link;
    status.delivery = status_on_top.delivery;
    return status;
  }
};

struct Rig {
  explicit Rig(const FrameMachineSettings& settings = everything(),
               std::vector<std::unique_ptr<sim::Node>> nodes = {}, std::size_t report_queue = 64)
      : line({}, std::move(nodes)), exchange(16, report_queue), machine(settings, bus, exchange) {}

  void order_at(can::Time when, layer2::OrderId id, const can::Frame& frame, can::Time timeout = kTimeout) {
    bus.script.emplace(when, [this, id, frame, timeout] {
      EXPECT_TRUE(exchange.requests.try_push(layer2::SendOrder{id, frame, timeout}));
    });
  }
  void run_until(can::Time end) {
    bus.script.emplace(end, [this] { loop.request_stop(); });
    loop.run();
    SendDone done;
    while (exchange.done.try_pop(done)) answers.emplace(done.answer.id, done);
    ReceivedReport report;
    while (exchange.frames.try_pop(report)) received.push_back(report);
  }
  /// The only answer to an order.
  SendDone answer_to(layer2::OrderId id) {
    EXPECT_EQ(answers.count(id), 1u) << id;
    const auto found = answers.find(id);
    return found == answers.end() ? SendDone{} : found->second;
  }
  BusSnapshot status() {
    BusSnapshot newest;
    EXPECT_TRUE(exchange.status.read(newest));
    return newest;
  }

  sim::Line line;
  ScriptedBus bus{line};
  Layer2Exchange exchange;
  FrameMachine machine;
  DeadlineLoop<FrameMachine> loop{machine, bus};
  std::multimap<layer2::OrderId, SendDone> answers;
  std::vector<ReceivedReport> received;
};

inline std::vector<std::unique_ptr<sim::Node>> one(sim::FrameNodeSettings settings) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::FrameNode>(std::move(settings)));
  return nodes;
}

}  // namespace cansyncd::layer2_test
