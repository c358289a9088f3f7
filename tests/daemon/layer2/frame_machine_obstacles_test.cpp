// What ends an order whose frame cannot be sent, and what is told of the bus that is in its way.
#include "frame_machine_rig.h"

namespace cansyncd::layer2_test {
namespace {

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

// H 5.2: the overrun bits stand until the controlling computer takes them back.
TEST(FrameMachine, L22L24FramesThatTheControllerLostAreForgottenWithTheOverflowBits) {
  for (const layer2::Control how : {layer2::Control::reset_overflow, layer2::Control::reset_controller}) {
    Rig rig;
    std::vector<layer2::BusFault> faults;
    const auto look_at = [&](milliseconds when) {
      rig.bus.script.emplace(when, [&] { faults.push_back(layer2::bus_fault(rig.status().facts)); });
    };
    const auto lost_at = [&](milliseconds when, std::uint64_t frames) {
      rig.bus.script.emplace(when, [&rig, frames] { rig.bus.status_on_top.dropped = frames; });
    };
    lost_at(milliseconds(10), 3);
    look_at(milliseconds(1500));
    rig.bus.script.emplace(milliseconds(1510), [&rig, how] {
      EXPECT_TRUE(rig.exchange.requests.try_push(layer2::ControlOrder{.id = 1, .what = how}));
    });
    look_at(milliseconds(3000));
    lost_at(milliseconds(3010), 4);
    look_at(milliseconds(4500));
    rig.run_until(milliseconds(5000));
    using layer2::BusFault;
    EXPECT_EQ(faults, (std::vector{BusFault::overflow, BusFault::off, BusFault::overflow}));
    EXPECT_EQ(rig.status().controller.dropped, 4u);
  }
}

TEST(FrameMachine, AControllerThatCannotBeResetIsResetWhenItsInterfaceIsUp) {
  Rig rig;
  const auto reset_at = [&rig](milliseconds when, layer2::OrderId id, bool is_up) {
    rig.bus.script.emplace(when, [&rig, id, is_up] {
      rig.bus.can_be_reset = is_up;
      EXPECT_TRUE(rig.exchange.requests.try_push(
          layer2::ControlOrder{.id = id, .what = layer2::Control::reset_controller}));
    });
  };
  reset_at(milliseconds(10), 1, false);
  reset_at(milliseconds(20), 2, true);
  rig.run_until(milliseconds(50));
  EXPECT_EQ(rig.answer_to(1).refusal, layer2::Refusal::no_controller);
  EXPECT_EQ(rig.answer_to(2).refusal, layer2::Refusal::none);
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

TEST(FrameMachine, WhatKeepsAnObjectsFrameFromTheBusIsTheReasonOfItsTimeout) {
  const auto object_behind = [](unsigned orders, can::SendResult refusal) {
    FrameMachineSettings settings = everything();
    settings.module.objects[1] = {
        .rule = {.identifier = 0x300}, .transmit = true, .timeout = milliseconds(5)};
    Rig rig(settings);
    rig.bus.lose_echoes = true;
    rig.bus.refusal = refusal;
    rig.bus.status_on_top.delivery = can::Delivery::unacknowledged;
    for (layer2::OrderId id = 1; id <= orders; ++id)
      rig.order_at(milliseconds(1), id, data_frame(0x123, {}), milliseconds(500));
    rig.bus.script.emplace(milliseconds(10), [&rig] {
      layer2::ObjectOrder order{.id = 20, .kind = layer2::ObjectOrder::Kind::send, .number = 1};
      order.job.frame = data_frame(0x300, {});
      EXPECT_TRUE(rig.exchange.requests.try_push(order));
    });
    rig.run_until(milliseconds(50));
    EXPECT_EQ(rig.answer_to(20).answer.outcome, Outcome::timeout);
    return rig.answer_to(20).object.obstacle;
  };
  EXPECT_EQ(object_behind(0, can::SendResult::bus_off), layer2::Obstacle::bus_off);
  EXPECT_EQ(object_behind(layer2::Station::kMostHandedOver, can::SendResult::queued),
            layer2::Obstacle::not_delivered)
      << "the controller has no place";
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
}  // namespace cansyncd::layer2_test
