// What a station does with frames, timers, control and its image, in virtual time.
#include "frame_machine_rig.h"

namespace cansyncd::layer2_test {
namespace {

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
  const layer2::ControlOrder write{.id = 1, .what = layer2::Control::write_image, .written = 0};
  const layer2::ControlOrder owned{.id = 2, .what = layer2::Control::write_image};
  OutputImage outputs{.sending = true};
  outputs.bytes[0] = 0xAB;
  outputs.bytes[1] = 0xCD;
  rig.bus.script.emplace(milliseconds(5), [&] {
    rig.exchange.outputs.write(outputs);
    EXPECT_TRUE(rig.exchange.requests.try_push(write));
    EXPECT_TRUE(rig.exchange.requests.try_push(owned));
  });
  // Given for another table: nothing of it is taken.
  rig.bus.script.emplace(milliseconds(50), [&] {
    OutputImage other{.table = 1, .sending = true};
    rig.exchange.outputs.write(other);
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
  EXPECT_EQ(image.sent, 9u) << "from the interval on that follows the first bytes";
  EXPECT_TRUE(rig.received.empty());  // what the mapping takes goes to nobody else
}

}  // namespace
}  // namespace cansyncd::layer2_test
