// All services of a module together, on a bus that takes a frame at a time.
#include "layer2/module.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::remote;
using std::chrono::microseconds;
using std::chrono::milliseconds;

ModuleSettings everything() {
  ModuleSettings settings;
  settings.station.filter.add({0, 0x7FF, false, FrameKinds::data_and_remote});
  return settings;
}

Script script(const char* text) {
  Script read = parse_script(text);
  EXPECT_TRUE(read.problems.empty());
  return read;
}

TimerSettings timer(std::uint32_t identifier, Time period) {
  TimerSettings settings;
  settings.frame = data_frame(identifier, {});
  settings.period = period;
  return settings;
}

/// A frame and when it was handed over.
struct Sent {
  Time when;
  std::uint32_t identifier;
  friend bool operator==(const Sent&, const Sent&) = default;
  friend std::ostream& operator<<(std::ostream& stream, const Sent& sent) {
    return stream << sent.when.count() << "ns 0x" << std::hex << sent.identifier << std::dec;
  }
};

/// Drives a module until `end`; each frame is on the bus at once.
std::vector<Sent> run(Module& module, Time now, Time end) {
  std::vector<Sent> sent;
  for (;;) {
    module.advance(now);
    while (const auto frame = module.next_frame()) {
      sent.push_back({now, frame->id});
      module.handed_over();
      module.echo(*frame, now);
    }
    const Time next = module.next_deadline();
    EXPECT_GT(next, now);
    if (next >= end || next <= now) return sent;
    now = next;
  }
}

TEST(Module, L9TheScriptsOfPowerOnRunAndStop) {
  ModuleSettings settings = everything();
  settings.power_on = script("Send 1 0\nWait 10\nSend 2 0");
  settings.run = script("Send 3 0\nWait 10\nSend 4 0");
  settings.stop = script("Send 5 0");
  Module module(settings);
  module.begin(Time{0});
  EXPECT_TRUE(module.running());
  // The one of run begins when that of power-on has ended.
  const std::vector<Sent> wanted = {{Time{0}, 1}, {milliseconds(10), 2}, {milliseconds(10), 3}};
  EXPECT_EQ(run(module, Time{0}, milliseconds(15)), wanted);
  module.set_running(false, milliseconds(15));  // the rest of the script of run is not done
  EXPECT_EQ(run(module, milliseconds(15), milliseconds(50)), (std::vector<Sent>{{milliseconds(15), 5}}));
  module.set_running(false, milliseconds(50));
  EXPECT_TRUE(run(module, milliseconds(50), milliseconds(60)).empty());
  module.set_running(true, milliseconds(60));
  EXPECT_EQ(run(module, milliseconds(60), milliseconds(65)), (std::vector<Sent>{{milliseconds(60), 3}}));
}

TEST(Module, L12AScriptStartsAndStopsTimers) {
  ModuleSettings settings = everything();
  settings.timers[0] = timer(0x80, milliseconds(4));
  settings.run = script("Start 1\nWait 10\nStop 1");
  Module module(settings);
  module.begin(Time{0});
  const std::vector<Sent> wanted = {{Time{0}, 0x80}, {milliseconds(4), 0x80}, {milliseconds(8), 0x80}};
  EXPECT_EQ(run(module, Time{0}, milliseconds(50)), wanted);
}

TEST(Module, L12ATimerThatAScriptStartsSendsAtOnce) {
  ModuleSettings settings = everything();
  settings.timers[0] = timer(0x80, milliseconds(100));
  settings.timers[1] = timer(0x81, milliseconds(100));
  settings.run = script("Send 1 0\nStart 1\nWait 10\nStart 2");
  Module module(settings);
  module.begin(Time{0});
  const std::vector<Sent> wanted = {{Time{0}, 1}, {Time{0}, 0x80}, {milliseconds(10), 0x81}};
  EXPECT_EQ(run(module, Time{0}, milliseconds(50)), wanted);  // `run` expects no deadline that is over
}

TEST(Module, L5StopEndsWhatRunsAndRunBeginsAnew) {
  ModuleSettings settings = everything();
  settings.timers[2] = timer(0x80, milliseconds(4));
  settings.timers[3] = timer(0x701, milliseconds(100));
  settings.stop = script("Start 4");  // a heartbeat goes on in stop
  settings.mapped = {{.identifier = 0x201, .size = 1, .output = true}};
  Module module(settings);
  module.begin(Time{0});
  module.mapping().set_sending(true);
  ASSERT_TRUE(module.start_timer(3, Time{0}));
  EXPECT_EQ(run(module, Time{0}, milliseconds(9)).size(), 4u);
  ASSERT_EQ(
      module.submit({.id = 7, .frame = data_frame(1, {}), .timeout = milliseconds(50)}, milliseconds(9)),
      Refusal::none);
  module.receive(data_frame(1, {}), milliseconds(9));
  module.set_running(false, milliseconds(9));
  EXPECT_EQ(module.take_answer()->outcome, Outcome::deleted);
  EXPECT_FALSE(module.take_received());
  EXPECT_EQ(
      module.submit({.id = 8, .frame = data_frame(1, {}), .timeout = milliseconds(50)}, milliseconds(9)),
      Refusal::not_running);
  module.receive(data_frame(1, {}), milliseconds(10));
  EXPECT_FALSE(module.take_received());
  const std::vector<Sent> wanted = {{milliseconds(9), 0x701}, {milliseconds(109), 0x701}};
  EXPECT_EQ(run(module, milliseconds(9), milliseconds(200)), wanted);
  EXPECT_FALSE(module.status().running);
  module.set_running(true, milliseconds(200));
  EXPECT_TRUE(module.status().running);
  EXPECT_EQ(run(module, milliseconds(200), milliseconds(205)).front().identifier, 0x201u);
}

TEST(Module, AMappedTelegramWhoseEchoIsOvertakenGoesOnceMore) {
  ModuleSettings settings = everything();
  settings.mapping.on_change = true;
  settings.mapped = {{.identifier = 0x201, .size = 1, .output = true}};
  Module module(settings);
  module.begin(Time{0});
  module.mapping().set_sending(true);
  EXPECT_EQ(run(module, Time{0}, milliseconds(5)).size(), 1u);
  module.mapping().outputs()[0] = 7;
  module.advance(milliseconds(10));
  EXPECT_EQ(module.next_frame(), data_frame(0x201, {7}));
  module.handed_over();
  ASSERT_EQ(module.submit({1, data_frame(0x300, {}), milliseconds(100)}, milliseconds(10)), Refusal::none);
  const auto other = module.next_frame();
  ASSERT_TRUE(other);
  module.handed_over();
  module.echo(*other, milliseconds(11));
  const Time next = milliseconds(20);
  EXPECT_EQ(run(module, next, milliseconds(35)), (std::vector<Sent>{{next, 0x201}}));
}

TEST(Module, L5ItCanWaitInStop) {
  ModuleSettings settings = everything();
  settings.starts_in_run = false;
  settings.run = script("Send 3 0");
  Module module(settings);
  module.begin(Time{0});
  EXPECT_TRUE(run(module, Time{0}, milliseconds(10)).empty());
  EXPECT_FALSE(module.running());
}

TEST(Module, L7WhatARangeOfHighPriorityTakesOvertakes) {
  ModuleSettings settings;
  settings.station.filter.add({0x100, 0x1FF, false, FrameKinds::data_and_remote, true});
  settings.station.filter.add({0x000, 0x7FF, false, FrameKinds::data_and_remote, false});
  Module module(settings);
  module.begin(Time{0});
  for (const std::uint32_t id : {0x200u, 0x100u, 0x201u, 0x101u}) module.receive(data_frame(id, {}), Time{1});
  for (const std::uint32_t id : {0x100u, 0x101u, 0x200u, 0x201u}) {
    const auto taken = module.take_received();
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->frame.id, id);
    EXPECT_EQ(taken->priority, id < 0x200 ? Priority::high : Priority::normal);
  }
}

TEST(Module, L8TheNodeFilterTakesItsNodeAndNodeZero) {
  ModuleSettings settings;
  settings.station.node = NodeFilter{.node = 5};
  Module module(settings);
  module.begin(Time{0});
  unsigned taken = 0;
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    module.receive(data_frame(id, {}), Time{1});
    const bool wanted = id % 128 == 5 || id % 128 == 0;
    EXPECT_EQ(module.take_received().has_value(), wanted) << id;
    taken += wanted ? 1 : 0;
  }
  EXPECT_EQ(taken, 32u);
  module.receive(can::test::extended(data_frame(5, {})), Time{1});
  EXPECT_FALSE(module.take_received());
  EXPECT_EQ(module.status().node, 5);
}

TEST(Module, L14L15ReceiveQueuesHaveTheirDepthAndLoseTheOldestWithABit) {
  Module module(everything());
  module.begin(Time{0});
  EXPECT_EQ(module.receive_queue(Priority::normal).depth, 400);
  EXPECT_EQ(module.receive_queue(Priority::high).depth, 20);
  EXPECT_EQ(module.station().queue(Priority::normal).depth, 400);
  EXPECT_EQ(module.station().queue(Priority::high).depth, 20);
  for (unsigned i = 0; i < 401; ++i) {
    const auto low = static_cast<std::uint8_t>(i);
    module.receive(data_frame(0x100, {low, static_cast<std::uint8_t>(i >> 8)}), Time{i});
  }
  EXPECT_TRUE(module.status().receive.overflowed);
  EXPECT_EQ(module.take_received()->end, Time{1});
  EXPECT_EQ(module.receive_queue(Priority::normal).lost, 1u);
  module.reset_overflow();
  EXPECT_FALSE(module.status().receive.overflowed);
  EXPECT_TRUE(module.status().receive.normal_half_full);
  module.clear_queues();
  EXPECT_TRUE(module.status().receive.empty);
  EXPECT_FALSE(module.take_received());
}

TEST(Module, L44OwnFramesAreNotReceived) {
  Module module(everything());
  module.begin(Time{0});
  ASSERT_EQ(module.objects().configure(1, {{.identifier = 0x100}, false, Time{0}}), ObjectProblem::none);
  ASSERT_EQ(module.objects().release(1), ObjectProblem::none);
  ASSERT_EQ(module.submit({.id = 1, .frame = data_frame(0x100, {}), .timeout = milliseconds(50)}, Time{0}),
            Refusal::none);
  EXPECT_EQ(run(module, Time{0}, milliseconds(1)).size(), 1u);
  EXPECT_FALSE(module.objects().read(1, false));
  EXPECT_FALSE(module.take_received());
  EXPECT_EQ(module.take_answer()->outcome, Outcome::done);
}

TEST(Module, L59TheOrderOfTheServices) {
  ModuleSettings settings = everything();
  settings.timers[0] = timer(0x10, milliseconds(100));
  settings.run = script("Start 1\nSend 0x11 0");
  settings.mapping.rule = {.identifier = 0x200, .mask = 0x700};
  settings.mapped = {{.identifier = 0x201, .size = 1, .output = true}, {.identifier = 0x202, .size = 1}};
  Module module(settings);
  module.begin(Time{0});
  module.mapping().set_sending(true);
  ASSERT_EQ(module.objects().configure(27, {{.identifier = 0x700}, true, Time{0}}), ObjectProblem::none);
  EXPECT_EQ(module.objects().configure(29, {{.identifier = 0x700}, true, Time{0}}), ObjectProblem::reserved);
  ASSERT_EQ(module.objects().start(27, {data_frame(0x700, {})}, Time{0}), ObjectProblem::none);
  for (const OrderId id : {OrderId{1}, OrderId{2}}) {
    const Priority priority = id == 2 ? Priority::high : Priority::normal;
    ASSERT_EQ(module.submit({id, data_frame(static_cast<std::uint32_t>(id), {}), milliseconds(50), priority},
                            Time{0}),
              Refusal::none);
  }
  std::vector<std::uint32_t> order;
  for (const Sent& sent : run(module, Time{0}, milliseconds(1))) order.push_back(sent.identifier);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x10, 0x11, 0x700, 0x201, 2, 1}));
  // And of receiving: an object, when it is full the mapping, what is neither's the queues.
  ASSERT_EQ(module.objects().configure(0, {{.identifier = 0x202}, false, Time{0}}), ObjectProblem::none);
  ASSERT_EQ(module.objects().release(0), ObjectProblem::none);
  module.receive(data_frame(0x202, {1}), Time{1});
  EXPECT_EQ(module.mapping().inputs()[0], 0);
  module.receive(data_frame(0x202, {2}), Time{2});
  EXPECT_EQ(module.mapping().inputs()[0], 2);
  EXPECT_TRUE(module.objects().read(0, false)->overrun);
  module.receive(data_frame(0x203, {2}), Time{2});  // the mapping's, and dropped
  EXPECT_FALSE(module.take_received());
  module.receive(data_frame(0x300, {}), Time{3});
  EXPECT_EQ(module.take_received()->frame.id, 0x300u);
  EXPECT_EQ(module.station().counters().received, 4u);
  EXPECT_EQ(module.station().counters().taken, 1u) << "by a range";
  EXPECT_EQ(module.taken_by_objects(), 1u);
  EXPECT_EQ(module.mapping().received(), 1u);
  EXPECT_EQ(module.mapping().dropped(), 1u);
}

TEST(Module, L13AWindowThatTheScriptOfPowerOnHasStartedGoesOnInRun) {
  ModuleSettings settings = everything();
  settings.window = {true, milliseconds(10), milliseconds(2), milliseconds(3), true};
  settings.power_on = script("Start 1\nStart 2");
  settings.starts_in_run = false;
  Module module(settings);
  module.begin(Time{0});
  module.advance(Time{0});
  ASSERT_TRUE(module.window().runs());
  module.set_running(true, milliseconds(5));
  EXPECT_TRUE(module.window().runs());
  module.set_running(false, milliseconds(6));
  EXPECT_FALSE(module.window().runs());
}

TEST(Module, L13OrdersWaitForTheWindowAndEndInIt) {
  ModuleSettings settings = everything();
  settings.window = {true, milliseconds(10), milliseconds(2), milliseconds(3), true};
  settings.run = script("Start 1\nStart 2");
  settings.timers[2] = timer(0x80, milliseconds(10));
  Module module(settings);
  module.begin(Time{0});
  module.advance(Time{0});
  ASSERT_TRUE(module.window().runs());
  ASSERT_TRUE(module.start_timer(3, Time{0}));
  for (OrderId id = 1; id <= 5; ++id) {
    ASSERT_EQ(module.submit({id, data_frame(0x100, {}), milliseconds(100)}, Time{0}), Refusal::none);
  }
  // Frames take their time here: three have room in each window.
  std::vector<Time> orders;
  std::vector<Time> timers;
  for (Time now{0}; now < milliseconds(30); now += microseconds(10)) {
    module.advance(now);
    const auto frame = module.next_frame();
    if (!frame) continue;
    module.handed_over();
    (frame->id == 0x80 ? timers : orders).push_back(now);
    now += microseconds(320);
    module.echo(*frame, now);
    now -= microseconds(10);
  }
  ASSERT_EQ(orders.size(), 5u);
  for (const Time when : orders) {
    EXPECT_GE(when % milliseconds(10), milliseconds(2));
    EXPECT_LE(when % milliseconds(10) + microseconds(320), milliseconds(3));
  }
  EXPECT_GE(orders[3], milliseconds(12));
  EXPECT_EQ(timers, (std::vector<Time>{Time{0}, milliseconds(10), milliseconds(20)}));
}

/// What is told of an order that times out behind the closed window of a module.
Obstacle behind_the_window(bool bus_was_off) {
  ModuleSettings settings = everything();
  settings.window = {true, milliseconds(100), milliseconds(1), milliseconds(2), true};
  settings.run = script("Start 1\nStart 2");
  Module module(settings);
  module.begin(Time{0});
  module.advance(Time{0});
  EXPECT_EQ(module.submit({1, data_frame(0x100, {}), milliseconds(50)}, Time{0}), Refusal::none);
  if (bus_was_off) {
    module.advance(milliseconds(1));
    EXPECT_TRUE(module.next_frame());
    module.held_back(Obstacle::bus_off);
  }
  module.advance(milliseconds(3));
  EXPECT_FALSE(module.next_frame());
  module.advance(milliseconds(50));
  const auto answer = module.take_answer();
  EXPECT_TRUE(answer && answer->outcome == Outcome::timeout);
  return answer.value_or(Answer{}).obstacle;
}

TEST(Module, L13TheClosedWindowIsTheReasonOfATimeoutUnlessTheBusTookNothingInIt) {
  EXPECT_EQ(behind_the_window(false), Obstacle::window_closed);
  EXPECT_EQ(behind_the_window(true), Obstacle::bus_off);
}

TEST(Module, L13TheWindowIsNoReasonOfATimeoutWithoutIt) {
  ModuleSettings settings = everything();
  settings.window = {true, milliseconds(100), milliseconds(1), milliseconds(2), false};
  settings.run = script("Start 1\nStart 2");
  Module module(settings);
  module.begin(Time{0});
  module.advance(Time{0});
  SendOrder high{1, data_frame(0x100, {}), milliseconds(50)};
  high.priority = Priority::high;
  EXPECT_EQ(module.submit(high, Time{0}), Refusal::none);
  ASSERT_TRUE(module.next_frame()) << "the window does not hold it";
  module.advance(milliseconds(50));
  const auto answer = module.take_answer();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->obstacle, Obstacle::none);
}

TEST(Module, L47AnOrderByIdentifierIsPutSecondAtBest) {
  Module module(everything());
  module.begin(Time{0});
  const auto submit = [&](std::uint32_t id, Placing placing) {
    ASSERT_EQ(module.submit({id, data_frame(id, {}), milliseconds(50), Priority::normal, placing}, Time{0}),
              Refusal::none);
  };
  submit(0x300, Placing::last);
  submit(0x200, Placing::last);
  submit(0x100, Placing::by_identifier);
  submit(0x200, Placing::by_identifier);  // behind its equal
  submit(0x400, Placing::by_identifier);
  std::vector<std::uint32_t> order;
  for (const Sent& sent : run(module, Time{0}, milliseconds(1))) order.push_back(sent.identifier);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0x300, 0x100, 0x200, 0x200, 0x400}));
}

TEST(Module, L15AFullSendQueueDeletesTheOldestAndSaysSo) {
  ModuleSettings settings = everything();
  settings.station.queue = 2;
  settings.station.overflow = Overflow::delete_oldest;
  Module module(settings);
  module.begin(Time{0});
  for (OrderId id = 1; id <= 3; ++id) {
    ASSERT_EQ(module.submit({id, data_frame(0x100, {}), milliseconds(50)}, Time{0}), Refusal::none);
  }
  const auto answer = module.take_answer();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->id, 1u);
  EXPECT_EQ(answer->outcome, Outcome::displaced);
  EXPECT_TRUE(module.status().send.overflowed);
  EXPECT_EQ(run(module, Time{0}, milliseconds(1)).size(), 2u);
}

TEST(Module, L46AFullSendQueueRefusesTheNewest) {
  ModuleSettings settings = everything();
  settings.station.queue = 2;
  Module module(settings);
  module.begin(Time{0});
  for (OrderId id = 1; id <= 3; ++id) {
    EXPECT_EQ(module.submit({id, data_frame(0x100, {}), milliseconds(50)}, Time{0}),
              id == 3 ? Refusal::queue_full : Refusal::none);
  }
  EXPECT_EQ(run(module, Time{0}, milliseconds(1)).size(), 2u);
}

}  // namespace
}  // namespace layer2
