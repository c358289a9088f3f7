// A station on the simulated bus, in virtual time: the realtime loop with the machine on it.
#include "daemon/layer2/realtime/frame_machine.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "can/flagged_frames.h"
#include "daemon/loop/deadline_loop.h"
#include "daemon/loop/flight_tap.h"
#include "layer2/sim/frame_node.h"
#include "rt/flight_recorder.h"
#include "sim/line.h"

namespace cansyncd {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using layer2::Outcome;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr can::Time kTimeout = milliseconds(100);

FrameMachineSettings everything() {
  FrameMachineSettings settings;
  settings.wall_clock = nullptr;
  settings.bits_per_second = 1'000'000;
  settings.module.station.filter.add({0, 0x7FF, false, layer2::FrameKinds::data_and_remote});
  settings.module.station.filter.add({0, 0x1FFFFFFF, true, layer2::FrameKinds::data_and_remote});
  return settings;
}

/// Does what the test wants at an instant of the bus, before the machine looks.
class ScriptedBus final : public can::Bus {
 public:
  explicit ScriptedBus(can::Bus& line) : line_(line) {}

  std::multimap<can::Time, std::function<void()>> script;
  can::SendResult refusal = can::SendResult::queued;  ///< what `send` says instead of sending
  can::ControllerStatus status_on_top;                ///< what of the status is not the line's
  bool lose_echoes = false;                           ///< none comes

  can::Time now() noexcept override { return line_.now(); }
  can::Wake wait_until(can::Time deadline) noexcept override {
    if (!script.empty()) deadline = std::min(deadline, script.begin()->first);
    const can::Wake wake = line_.wait_until(deadline);
    while (!script.empty() && script.begin()->first <= line_.now()) {
      const auto action = script.begin()->second;
      script.erase(script.begin());
      action();
    }
    return wake;
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    while (line_.receive(out)) {
      if (!out.own || !lose_echoes) return true;
    }
    return false;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    return refusal == can::SendResult::queued ? line_.send(frame) : refusal;
  }
  can::ControllerStatus status() noexcept override {
    can::ControllerStatus status = line_.status();
    status.unacknowledged = status_on_top.unacknowledged;
    status.dropped = status_on_top.dropped;
    status.state = status_on_top.state;
    status.link = status_on_top.link;
    status.delivery = status_on_top.delivery;
    return status;
  }
  can::ResetResult reset() noexcept override { return line_.reset(); }
  can::ResetResult reset_result() noexcept override { return line_.reset_result(); }
  can::TimestampSource timestamp_source() noexcept override { return line_.timestamp_source(); }

 private:
  can::Bus& line_;
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

std::vector<std::unique_ptr<sim::Node>> one(sim::FrameNodeSettings settings) {
  std::vector<std::unique_ptr<sim::Node>> nodes;
  nodes.push_back(std::make_unique<sim::FrameNode>(std::move(settings)));
  return nodes;
}

TEST(FrameMachine, SendsFramesOfEveryKindAndAnswersEachOnce) {
  Rig rig;
  layer2::OrderId id = 0;
  for (const can::Frame& frame : can::test::four_kinds()) rig.order_at(milliseconds(1), ++id, frame);
  rig.run_until(milliseconds(20));
  ASSERT_EQ(rig.answers.size(), id);
  can::Time before{0};
  for (layer2::OrderId i = 1; i <= id; ++i) {
    const SendDone done = rig.answer_to(i);
    EXPECT_EQ(done.refusal, layer2::Refusal::none);
    EXPECT_EQ(done.answer.outcome, Outcome::done);
    EXPECT_GT(done.sent_time, before);  // in the order they were asked for
    before = done.sent_time;
  }
  EXPECT_EQ(rig.status().counters.sent, id);
}

TEST(FrameMachine, ARequestWaitsNoLongerThanALook) {
  Rig rig;
  rig.order_at(microseconds(5500), 1, data_frame(0x123, {1}));
  rig.run_until(milliseconds(20));
  const can::Time length = rig.line.bit_times(100);
  EXPECT_LT(rig.answer_to(1).sent_time, microseconds(5500) + milliseconds(1) + length);
}

TEST(FrameMachine, ARemoteFrameIsAnsweredByTheNodeThatHasTheData) {
  Rig rig(everything(), one({.answers = {extended(data_frame(0x18DAF110, {1, 2, 3}))}}));
  rig.order_at(milliseconds(1), 1, extended(remote(data_frame(0x18DAF110, {0, 0, 0}))));
  rig.run_until(milliseconds(20));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::done);
  ASSERT_EQ(rig.received.size(), 1u);  // the own frame is not received
  EXPECT_EQ(rig.received[0].frame, extended(data_frame(0x18DAF110, {1, 2, 3})));
  EXPECT_EQ(rig.received[0].range, 1);
  EXPECT_GT(rig.received[0].receive_time, rig.answer_to(1).sent_time);
}

TEST(FrameMachine, OnlyFramesThatARangeTakesAreHandedOn) {
  FrameMachineSettings settings;
  settings.wall_clock = nullptr;
  settings.module.station.filter.add({0x200, 0x2FF, false, layer2::FrameKinds::data_and_remote});
  std::vector<std::unique_ptr<sim::Node>> nodes;
  for (const std::uint32_t identifier : {0x1FFu, 0x200u, 0x2FFu, 0x300u}) {
    nodes.push_back(std::make_unique<sim::FrameNode>(
        sim::FrameNodeSettings{.periodic = remote(data_frame(identifier, {})), .period = milliseconds(10)}));
  }
  Rig rig(settings, std::move(nodes));
  rig.run_until(milliseconds(15));
  ASSERT_EQ(rig.received.size(), 2u);
  EXPECT_EQ(rig.received[0].frame.id, 0x200u);
  EXPECT_EQ(rig.received[1].frame.id, 0x2FFu);
  const BusSnapshot status = rig.status();
  EXPECT_EQ(status.counters.received, 4u);
  EXPECT_EQ(status.counters.taken, 2u);
}

TEST(FrameMachine, FramesThatFollowEachOtherWakeTheGatewayTogether) {
  Rig rig(everything(), one({.periodic = data_frame(0x080, {0}), .period = microseconds(200)}));
  unsigned wakes = 0;
  unsigned frames = 0;
  ReceivedReport report;
  for (can::Time at = milliseconds(5); at < milliseconds(15); at += microseconds(50)) {
    rig.bus.script.emplace(at, [&] {
      if (!rig.exchange.gateway_wake.wait(milliseconds(0))) return;
      ++wakes;
      while (rig.exchange.frames.try_pop(report)) ++frames;
    });
  }
  rig.run_until(milliseconds(16));
  EXPECT_GT(frames, 35u);
  EXPECT_GE(wakes, 9u) << "none waits longer than a look";
  EXPECT_LE(wakes, 21u) << "at most one in 500 us";
}

TEST(FrameMachine, WhatDoesNotFitIsCounted) {
  FrameMachineSettings settings = everything();
  settings.module.receive_queue = 8;
  Rig rig(settings, one({.periodic = data_frame(0x100, {0}), .period = milliseconds(1)}), 16);
  rig.run_until(milliseconds(60));
  EXPECT_EQ(rig.received.size(), 16u);
  const BusSnapshot status = rig.status();
  EXPECT_EQ(status.lost, status.counters.taken - 16u - 8u);
  EXPECT_GT(status.lost, 0u);
  EXPECT_TRUE(status.facts.receive.overflowed);
}

TEST(FrameMachine, L9L11L12AScriptStartsATimerAndItsFramesStandOnTheBus) {
  FrameMachineSettings settings = everything();
  layer2::TimerSettings sync;
  sync.frame = data_frame(0x80, {});
  sync.period = milliseconds(10);
  settings.module.timers[2] = sync;
  settings.module.run = layer2::parse_script("Send 0x000 2 1 0\nWait 5\nStart 3");
  Rig rig(settings);
  rig.run_until(milliseconds(48));
  const BusSnapshot status = rig.status();
  EXPECT_EQ(status.counters.sent, 6u);  // the script's, and at 5, 15, 25, 35, 45 ms
  EXPECT_TRUE(status.timers[2].running);
  EXPECT_EQ(status.timers[2].sent, 5u);
  EXPECT_EQ(status.timers[2].left_out, 0u);
  EXPECT_FALSE(status.script_running);
  EXPECT_TRUE(rig.received.empty());
}

TEST(FrameMachine, L5L18L19ControlIsAnsweredOnce) {
  FrameMachineSettings settings = everything();
  layer2::TimerSettings sync;
  sync.frame = data_frame(0x80, {});
  settings.module.timers[0] = sync;
  Rig rig(settings);
  const auto control_at = [&](can::Time when, layer2::ControlOrder order) {
    rig.bus.script.emplace(when, [&rig, order] { EXPECT_TRUE(rig.exchange.requests.try_push(order)); });
  };
  control_at(milliseconds(1), {.id = 1, .what = layer2::Control::start_timer, .number = 1});
  control_at(milliseconds(2), {.id = 2, .what = layer2::Control::start_timer, .number = 2});
  control_at(milliseconds(30), {.id = 3, .what = layer2::Control::stop});
  rig.order_at(milliseconds(40), 4, data_frame(1, {}));
  control_at(milliseconds(50), {.id = 5, .what = layer2::Control::run});
  rig.order_at(milliseconds(60), 6, data_frame(1, {}));
  control_at(milliseconds(70), {.id = 7, .what = layer2::Control::reset_controller});
  rig.run_until(milliseconds(100));
  EXPECT_EQ(rig.answer_to(1).refusal, layer2::Refusal::none);
  EXPECT_EQ(rig.answer_to(2).refusal, layer2::Refusal::no_timer);
  EXPECT_EQ(rig.answer_to(3).refusal, layer2::Refusal::none);
  EXPECT_EQ(rig.answer_to(4).refusal, layer2::Refusal::not_running);
  EXPECT_EQ(rig.answer_to(5).refusal, layer2::Refusal::none);
  EXPECT_EQ(rig.answer_to(6).answer.outcome, Outcome::done);
  EXPECT_EQ(rig.answer_to(7).refusal, layer2::Refusal::none);
  EXPECT_EQ(rig.status().timers[0].sent, 1u);
}

TEST(FrameMachine, L52L55TheProcessImageIsExchanged) {
  FrameMachineSettings settings = everything();
  settings.module.mapped = {{.identifier = 0x181, .address = 3, .size = 2},
                            {.identifier = 0x201, .address = 0, .size = 2, .output = true}};
  settings.module.mapping.rule = {.identifier = 0x181, .mask = 0x7FF};
  Rig rig(settings, one({.periodic = data_frame(0x181, {0, 7}), .period = milliseconds(20)}));
  const layer2::ControlOrder write{.id = 1, .what = layer2::Control::write_image, .written = true};
  const layer2::ControlOrder owned{.id = 2, .what = layer2::Control::write_image};
  OutputImage outputs;
  outputs.bytes[0] = 0xAB;
  outputs.bytes[1] = 0xCD;
  rig.bus.script.emplace(milliseconds(5), [&] {
    rig.exchange.outputs.write(outputs);
    EXPECT_TRUE(rig.exchange.requests.try_push(write));
    EXPECT_TRUE(rig.exchange.requests.try_push(owned));
  });
  rig.run_until(milliseconds(95));
  EXPECT_EQ(rig.answer_to(1).refusal, layer2::Refusal::none);
  EXPECT_EQ(rig.answer_to(2).refusal, layer2::Refusal::image_owned);
  ImageSnapshot image;
  ASSERT_TRUE(rig.exchange.image.read(image));
  EXPECT_TRUE(image.exchanging);
  EXPECT_EQ(image.inputs[4], 7);
  EXPECT_GT(image.received, 2u);
  EXPECT_EQ(image.outputs[1], 0xCD);
  EXPECT_EQ(image.sent, 10u);
  EXPECT_TRUE(rig.received.empty());  // what the mapping takes goes to nobody else
}

TEST(FrameMachine, ABusThatTakesNothingIsTheReasonOfATimeout) {
  Rig rig;
  rig.bus.refusal = can::SendResult::bus_off;
  rig.order_at(milliseconds(1), 1, data_frame(0x123, {1}), milliseconds(20));
  rig.run_until(milliseconds(50));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::timeout);
  EXPECT_EQ(rig.answer_to(1).answer.obstacle, layer2::Obstacle::bus_off);
}

TEST(FrameMachine, AControllerThatWasEmptiedEndsWhatItHad) {
  Rig rig;
  rig.order_at(milliseconds(1), 1, data_frame(0x123, {1, 2, 3, 4, 5, 6, 7, 8}), milliseconds(500));
  rig.order_at(milliseconds(1), 2, data_frame(0x124, {1, 2, 3, 4, 5, 6, 7, 8}), milliseconds(500));
  // The first frame is on the bus then, the second behind it in the controller.
  rig.bus.script.emplace(milliseconds(1) + microseconds(10), [&rig] {
    rig.line.reset();
    rig.bus.status_on_top.unacknowledged = 2;
  });
  rig.run_until(milliseconds(10));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::no_answer);
  EXPECT_EQ(rig.answer_to(2).answer.outcome, Outcome::no_answer);
}

TEST(FrameMachine, AWaitingOrderIsTakenBack) {
  Rig rig;
  rig.bus.refusal = can::SendResult::queue_full;
  rig.order_at(milliseconds(1), 1, data_frame(0x123, {}));
  rig.bus.script.emplace(milliseconds(5),
                         [&rig] { EXPECT_TRUE(rig.exchange.requests.try_push(CancelOrder{1})); });
  rig.run_until(milliseconds(10));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::cancelled);
}

TEST(FrameMachine, StoppingAnswersWhatIsOpenAndWhatWasNotTaken) {
  Rig rig;
  rig.bus.refusal = can::SendResult::interface_down;
  rig.order_at(milliseconds(1), 1, data_frame(0x123, {}));
  rig.order_at(milliseconds(5), 2, data_frame(0x124, {}));  // in the instant of the stop: not looked at
  rig.run_until(milliseconds(5));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::stopped);
  EXPECT_EQ(rig.answer_to(2).answer.outcome, Outcome::stopped);
  EXPECT_EQ(rig.answer_to(2).refusal, layer2::Refusal::none);
}

TEST(FrameMachine, EchoesThatWereDroppedDoNotEndTheSending) {
  Rig rig;
  rig.bus.lose_echoes = true;
  for (layer2::OrderId id = 1; id <= layer2::Station::kMostHandedOver; ++id)
    rig.order_at(milliseconds(1), id, data_frame(0x100, {static_cast<std::uint8_t>(id)}), milliseconds(20));
  rig.bus.script.emplace(milliseconds(10), [&rig] {
    rig.bus.lose_echoes = false;
    rig.bus.status_on_top.dropped = layer2::Station::kMostHandedOver;
  });
  rig.order_at(milliseconds(30), 20, data_frame(0x123, {1}));
  rig.run_until(milliseconds(50));
  for (layer2::OrderId id = 1; id <= layer2::Station::kMostHandedOver; ++id)
    EXPECT_EQ(rig.answer_to(id).answer.outcome, Outcome::no_answer) << id;
  EXPECT_EQ(rig.answer_to(20).answer.outcome, Outcome::done);
}

TEST(FrameMachine, ADroppedEchoIsMissedByItsOwnFrameAlone) {
  Rig rig;
  rig.bus.lose_echoes = true;
  // Each is answered before the next is asked for.
  for (layer2::OrderId id = 1; id <= 4; ++id)
    rig.order_at(milliseconds(30 * id), id, data_frame(0x123, {1}), milliseconds(20));
  rig.bus.script.emplace(milliseconds(40), [&rig] {
    rig.bus.lose_echoes = false;
    rig.bus.status_on_top.dropped = 1;
  });
  rig.run_until(milliseconds(150));
  EXPECT_EQ(rig.answer_to(1).answer.outcome, Outcome::no_answer);
  for (layer2::OrderId id = 2; id <= 4; ++id)
    EXPECT_EQ(rig.answer_to(id).answer.outcome, Outcome::done) << id;
}

TEST(FrameMachine, WhatKeepsTheControllerFromSendingIsTheReasonOfATimeoutBehindIt) {
  std::vector<std::pair<can::ControllerStatus, layer2::Obstacle>> cases(4);
  cases[0].second = layer2::Obstacle::none;  // earlier frames
  cases[1] = {{.delivery = can::Delivery::unacknowledged}, layer2::Obstacle::not_delivered};
  cases[2] = {{.state = can::ControllerState::bus_off}, layer2::Obstacle::bus_off};
  cases[3] = {{.link = can::LinkState::missing}, layer2::Obstacle::interface_down};
  for (const auto& [status, obstacle] : cases) {
    Rig rig;
    rig.bus.lose_echoes = true;
    rig.bus.status_on_top = status;
    for (layer2::OrderId id = 1; id <= layer2::Station::kMostHandedOver + 1; ++id)
      rig.order_at(milliseconds(1), id, data_frame(0x123, {}), milliseconds(20));
    rig.run_until(milliseconds(50));
    const layer2::Answer last = rig.answer_to(layer2::Station::kMostHandedOver + 1).answer;
    EXPECT_EQ(last.outcome, Outcome::timeout);
    EXPECT_EQ(last.obstacle, obstacle);
  }
}

TEST(FrameMachine, TheStateAtTheStartIsToldAtOnce) {
  Rig rig;
  rig.bus.status_on_top.link = can::LinkState::missing;
  rig.machine.begin(can::Time{0});
  rig.machine.publish(can::Time{0});
  EXPECT_TRUE(rig.exchange.gateway_wake.wait(milliseconds(0)));
  EXPECT_EQ(rig.status().controller.link, can::LinkState::missing);
}

/// What froze the recorder of a bus to which something happens at 5 ms; nothing: it was not frozen.
std::optional<rt::FlightTrigger> recorded(const FlightTriggers& triggers, const can::ControllerStatus& then) {
  rt::FlightRecorder recorder(256, 0);
  FlightTap tap(recorder, triggers);
  FrameMachineSettings settings = everything();
  settings.tap = &tap;
  Rig rig(settings);
  rig.bus.script.emplace(milliseconds(5), [&rig, &then] { rig.bus.status_on_top = then; });
  rig.run_until(milliseconds(10));
  if (!recorder.wait_frozen(milliseconds(0))) return std::nullopt;
  return recorder.trigger();
}

TEST(FrameMachine, ABusToWhichNothingCanBeHandedIsRecordedWhenThatIsWanted) {
  const can::ControllerStatus missing{.link = can::LinkState::missing};
  const can::ControllerStatus alone{.delivery = can::Delivery::unacknowledged};
  for (const auto& [then, detail] : {std::pair{missing, can::SendResult::interface_down},
                                     std::pair{alone, can::SendResult::not_delivered}}) {
    const auto trigger = recorded({}, then);
    ASSERT_TRUE(trigger);
    EXPECT_EQ(trigger->reason, static_cast<std::uint32_t>(FlightReason::sending_failed));
    EXPECT_EQ(trigger->detail, static_cast<std::uint64_t>(detail));
    EXPECT_FALSE(recorded({.sending_failed = false}, then));
  }
  EXPECT_FALSE(recorded({}, {}));
}

TEST(FrameMachine, NoAnswerIsLostWhenTheGatewayReadsNone) {
  Rig rig;
  rig.bus.refusal = can::SendResult::queue_full;
  unsigned pushed = 0;
  for (unsigned n = 0; n < 200; ++n) {
    rig.bus.script.emplace(milliseconds(1 + n), [&rig, &pushed] {
      for (unsigned i = 0; i < 16; ++i) {
        if (rig.exchange.requests.try_push(
                layer2::SendOrder{pushed + 1, data_frame(0x100, {}), milliseconds(1)}))
          ++pushed;
      }
    });
  }
  rig.run_until(milliseconds(300));
  // What was not taken because its answer has no room is left for the gateway.
  Layer2Request left;
  unsigned not_taken = 0;
  while (rig.exchange.requests.try_pop(left)) ++not_taken;
  EXPECT_EQ(rig.answers.size() + not_taken, pushed);
  for (layer2::OrderId id = 1; id <= rig.answers.size(); ++id) EXPECT_EQ(rig.answers.count(id), 1u) << id;
  EXPECT_GT(not_taken, 0u);
}

}  // namespace
}  // namespace cansyncd
