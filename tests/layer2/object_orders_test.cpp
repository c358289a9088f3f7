#include "layer2/object_orders.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>

#include "can/flagged_frames.h"
#include "layer2/module.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::remote;
using std::chrono::milliseconds;

using Kind = ObjectOrder::Kind;

constexpr Time kPatience = milliseconds(50);

ObjectEntry sender(std::uint8_t number, std::uint32_t identifier, Time timeout = Time{0}, bool tell = false) {
  return {number, {{.identifier = identifier}, true, timeout, tell}};
}
ObjectEntry receiver(std::uint8_t number, std::uint32_t identifier, bool tell = false) {
  return {number, {{.identifier = identifier}, false, Time{0}, tell}};
}
ObjectOrder send(OrderId id, std::uint8_t number, const can::Frame& frame) {
  return {.id = id, .kind = Kind::send, .number = number, .job = {.frame = frame}};
}
ObjectOrder read(OrderId id, std::uint8_t number, bool release) {
  return {.id = id, .kind = Kind::read, .number = number, .release = release};
}

/// A module that runs and has these objects.
struct Running {
  explicit Running(std::initializer_list<ObjectEntry> objects) : module(settings(objects)) {
    module.begin(Time{0});
  }
  static ModuleSettings settings(std::initializer_list<ObjectEntry> objects) {
    ModuleSettings settings;
    settings.object_patience = kPatience;
    for (const ObjectEntry& entry : objects) settings.objects[entry.number] = entry.settings;
    return settings;
  }
  /// The frame that the module hands over now.
  can::Frame hand_over() {
    const auto frame = module.next_frame();
    EXPECT_TRUE(frame);
    module.handed_over();
    return frame.value_or(can::Frame{});
  }
  /// Every answer there is to jobs.
  std::vector<ObjectAnswer> answers() {
    std::vector<ObjectAnswer> found;
    while (const auto answer = module.take_object_answer()) found.push_back(*answer);
    return found;
  }
  void take_job(const ObjectOrder& order, Time now = Time{0}) {
    EXPECT_FALSE(module.perform(order, now)) << "answered when it ends";
  }

  Module module;
};

TEST(ObjectOrders, L35AJobIsAnsweredOnceWhenItsFrameStoodOnTheBus) {
  Running rig({sender(3, 0x100)});
  rig.take_job(send(7, 3, data_frame(0x123, {1})));
  EXPECT_TRUE(rig.answers().empty());
  const can::Frame frame = rig.hand_over();
  EXPECT_EQ(frame, data_frame(0x123, {1}));
  EXPECT_TRUE(rig.answers().empty());
  EXPECT_EQ(rig.module.perform(send(8, 3, frame), Time{0})->refusal, Refusal::object_pending);
  rig.module.echo(frame, milliseconds(2));
  EXPECT_EQ(rig.module.perform(send(9, 3, frame), Time{0})->refusal, Refusal::object_pending)
      << "the one before was not answered yet";
  const auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].id, 7u);
  EXPECT_EQ(answers[0].outcome, Outcome::done);
  EXPECT_EQ(answers[0].time, milliseconds(2));
  const ObjectState state = rig.module.objects().state(3);
  EXPECT_EQ(state.sent, 1u);
  EXPECT_EQ(state.ended_as, JobState::done);
  EXPECT_EQ(state.place, JobPlace::none);
}

TEST(ObjectOrders, L36AbortedByAnOrderOrTakenBack) {
  Running rig({sender(3, 0x100), sender(4, 0x101), sender(5, 0x102)});
  for (const std::uint8_t number : std::array<std::uint8_t, 3>{3, 4, 5})
    rig.take_job(send(number, number, data_frame(0x100, {})));
  EXPECT_EQ(rig.module.perform({.id = 20, .kind = Kind::abort, .number = 4}, Time{0})->refusal,
            Refusal::none);
  EXPECT_TRUE(rig.module.cancel_object(5));
  EXPECT_FALSE(rig.module.cancel_object(77));
  (void)rig.hand_over();
  EXPECT_EQ(rig.module.perform({.id = 21, .kind = Kind::abort, .number = 3}, Time{0})->refusal,
            Refusal::object_pending)
      << "it may be on the bus";
  EXPECT_EQ(rig.module.perform({.id = 22, .kind = Kind::abort, .number = 9}, Time{0})->refusal,
            Refusal::object_direction);
  const std::array<ObjectEntry, 1> ninth = {sender(9, 0x109)};
  EXPECT_EQ(rig.module.perform({.id = 23, .kind = Kind::configure, .settings = ninth}, Time{0})->refusal,
            Refusal::none);
  rig.take_job(send(24, 9, data_frame(0x109, {})));
  EXPECT_EQ(rig.module.perform({.id = 25, .kind = Kind::abort, .number = 9}, Time{0})->refusal,
            Refusal::none);
  const auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 3u);
  for (const ObjectAnswer& answer : answers) EXPECT_EQ(answer.outcome, Outcome::cancelled);
}

TEST(ObjectOrders, AJobWhoseFrameIsInTheControllerIsNeverCancelledByOtherSettings) {
  // 4 sends by other settings from now on, 5 receives; 6 is forgotten with all others.
  for (const std::uint8_t number : std::array<std::uint8_t, 3>{4, 5, 6}) {
    Running rig({sender(4, 0x100), sender(5, 0x100), sender(6, 0x100)});
    rig.take_job(send(1, number, data_frame(0x100, {})));
    const can::Frame frame = rig.hand_over();
    const std::array<ObjectEntry, 1> other = {number == 4 ? sender(4, 0x105) : receiver(5, 0x105)};
    ASSERT_EQ(
        rig.module
            .perform({.id = 2, .kind = Kind::configure, .anew = number == 6, .settings = other}, Time{0})
            ->refusal,
        Refusal::none);
    const auto answers = rig.answers();
    ASSERT_EQ(answers.size(), 1u) << +number;
    EXPECT_EQ(answers[0].outcome, Outcome::no_answer) << +number;
    EXPECT_EQ(rig.module.objects().state(number).ended_as, JobState::timed_out);
    rig.module.echo(frame, milliseconds(2));
    EXPECT_EQ(rig.module.objects().state(number).sent, 1u) << "it stood on the bus after all";
    rig.module.echo(frame, milliseconds(3));
    EXPECT_EQ(rig.module.objects().state(number).sent, 1u);
  }
}

TEST(ObjectOrders, InStopNothingIsAskedFor) {
  Running rig({receiver(5, 0x102)});
  rig.module.set_running(false, Time{0});
  ObjectOrder ask = read(1, 5, true);
  ask.ask = true;
  EXPECT_EQ(rig.module.perform(ask, Time{0})->refusal, Refusal::not_running);
  EXPECT_EQ(rig.module.perform(read(2, 5, true), Time{0})->refusal, Refusal::none);
  rig.module.set_running(true, Time{0});
  EXPECT_FALSE(rig.module.next_frame());
}

TEST(ObjectOrders, L37TimedOutBeforeItWasHandedOverAndUnknownAfter) {
  Running rig({sender(3, 0x100, milliseconds(10)), sender(4, 0x101)});
  rig.take_job(send(1, 3, data_frame(0x100, {})));
  rig.module.advance(milliseconds(10));
  auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::timeout);
  rig.take_job(send(2, 4, data_frame(0x101, {})), milliseconds(10));
  const can::Frame frame = rig.hand_over();
  EXPECT_EQ(rig.module.next_deadline(), milliseconds(10) + kPatience);
  rig.module.advance(milliseconds(10) + kPatience);
  answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::no_answer);
  EXPECT_EQ(rig.module.objects().place(4), JobPlace::in_controller) << "it may be sent yet";
  rig.module.echo(frame, milliseconds(100));
  EXPECT_TRUE(rig.answers().empty());
  rig.take_job(send(3, 4, data_frame(0x101, {})), milliseconds(100));
  (void)rig.hand_over();
  rig.module.controller_emptied();
  answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::no_answer) << "it may have been sent";
}

TEST(ObjectOrders, L37ATimeoutSaysWhatKeptTheFrameFromTheBus) {
  Running rig({sender(3, 0x100, milliseconds(10)), sender(4, 0x101)});
  const auto timed_out_at = [&rig](Time now) {
    rig.module.advance(now);
    const auto answers = rig.answers();
    EXPECT_TRUE(answers.size() == 1 && answers[0].outcome == Outcome::timeout);
    return answers.empty() ? Obstacle::none : answers[0].obstacle;
  };
  rig.take_job(send(1, 3, data_frame(0x100, {})));
  ASSERT_TRUE(rig.module.next_frame());
  rig.module.held_back(Obstacle::not_delivered);
  EXPECT_EQ(timed_out_at(milliseconds(10)), Obstacle::not_delivered);
  rig.take_job(send(2, 3, data_frame(0x100, {})), milliseconds(10));
  EXPECT_EQ(timed_out_at(milliseconds(20)), Obstacle::none)
      << "what was in the way before is not of this job";
  rig.take_job(send(3, 4, data_frame(0x101, {})), milliseconds(20));
  rig.module.held_back(Obstacle::bus_off);
  (void)rig.hand_over();
  rig.take_job(send(4, 3, data_frame(0x100, {})), milliseconds(20));
  EXPECT_EQ(timed_out_at(milliseconds(30)), Obstacle::none) << "the bus took a frame since";
}

TEST(ObjectOrders, AJobWhoseEchoWasLostEndsAndTheObjectIsFree) {
  Running rig({sender(4, 0x101), receiver(6, 0x210)});
  rig.take_job(send(1, 4, data_frame(0x101, {})));
  (void)rig.hand_over();
  rig.module.echoes_lost();
  auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::no_answer) << "it may have been sent";
  EXPECT_EQ(rig.module.objects().place(4), JobPlace::none);
  // Nor does it come when that of a frame behind it has.
  rig.take_job(send(2, 4, data_frame(0x101, {})));
  (void)rig.hand_over();
  ASSERT_EQ(rig.module.submit({9, data_frame(0x300, {}), milliseconds(100)}, Time{0}), Refusal::none);
  rig.module.echo(rig.hand_over(), milliseconds(1));
  answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::no_answer);
  ObjectOrder ask = read(3, 6, true);
  ask.ask = true;
  for (unsigned n = 0; n < 2; ++n) {
    EXPECT_EQ(rig.module.perform(ask, Time{0})->refusal, Refusal::none);
    EXPECT_EQ(rig.hand_over(), remote(data_frame(0x210, {})));
    rig.module.echoes_lost();
  }
}

TEST(ObjectOrders, AnAnswerWhoseEchoWasLostIsGivenToTheNextRemoteFrame) {
  Running rig({sender(3, 0x100)});
  ObjectOrder order = send(1, 3, data_frame(0x100, {9}));
  order.job.on_remote = order.job.every_time = true;
  EXPECT_EQ(rig.module.perform(order, Time{0})->outcome, Outcome::done);
  const can::Frame question = remote(data_frame(0x100, {}));
  rig.module.receive(question, milliseconds(1));
  (void)rig.hand_over();
  rig.module.echoes_lost();
  EXPECT_FALSE(rig.module.next_frame());
  rig.module.receive(question, milliseconds(2));
  (void)rig.hand_over();
  rig.module.receive(question, milliseconds(3));  // while that is in the controller
  rig.module.echoes_lost();
  rig.module.echo(rig.hand_over(), milliseconds(4));
  EXPECT_EQ(rig.module.objects().place(3), JobPlace::waits_for_remote);
  EXPECT_FALSE(rig.module.next_frame());
}

TEST(ObjectOrders, L38AJobForRemoteFramesIsAnsweredWhenTheObjectHoldsIt) {
  Running rig({sender(3, 0x100)});
  ObjectOrder order = send(1, 3, data_frame(0x100, {9}));
  order.job.on_remote = order.job.every_time = true;
  EXPECT_EQ(rig.module.perform(order, Time{0})->outcome, Outcome::done);
  for (std::uint64_t n = 1; n <= 3; ++n) {
    rig.module.receive(remote(data_frame(0x100, {})), milliseconds(n));
    rig.module.echo(rig.hand_over(), milliseconds(n) + Time{1});
    EXPECT_EQ(rig.module.objects().state(3).sent, n);
    EXPECT_EQ(rig.module.objects().state(3).place, JobPlace::waits_for_remote);
  }
  EXPECT_TRUE(rig.answers().empty());
}

TEST(ObjectOrders, L34ConfiguringIsAllOrNothing) {
  Running rig({sender(3, 0x100), receiver(4, 0x200)});
  rig.module.objects().reserve(28);
  const std::array<ObjectEntry, 3> wrong = {receiver(3, 0x300), sender(28, 0x301), sender(5, 0x302)};
  auto answer = rig.module.perform({.id = 1, .kind = Kind::configure, .settings = wrong}, Time{0});
  EXPECT_EQ(answer->refusal, Refusal::object_reserved);
  EXPECT_EQ(answer->place, 1);
  EXPECT_TRUE(rig.module.objects().state(3).settings.transmit) << "nothing has changed";
  rig.take_job(send(2, 3, data_frame(0x100, {})));
  const can::Frame late = rig.hand_over();
  const std::array<ObjectEntry, 2> twice = {receiver(3, 0x300), sender(3, 0x303)};
  answer = rig.module.perform({.id = 3, .kind = Kind::configure, .anew = true, .settings = twice}, Time{0});
  EXPECT_EQ(answer->refusal, Refusal::none);
  EXPECT_EQ(rig.module.objects().state(3).settings.rule.identifier, 0x303u) << "the later counts";
  EXPECT_FALSE(rig.module.objects().state(4).configured) << "forgotten";
  auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::no_answer) << "the controller had its frame";
  // The frame of before, which the controller still had, is not that of the new job.
  rig.take_job(send(4, 3, data_frame(0x303, {})));
  (void)rig.hand_over();
  rig.module.echo(late, milliseconds(1));
  EXPECT_TRUE(rig.answers().empty());
  rig.module.echo(data_frame(0x303, {}), milliseconds(2));
  EXPECT_EQ(rig.answers().size(), 1u);
}

TEST(ObjectOrders, L40L41L42FetchedWithItsOverrunAndReleasedAnew) {
  Running rig({receiver(6, 0x210)});
  rig.module.receive(data_frame(0x210, {1}), milliseconds(1));
  auto answer = rig.module.perform(read(1, 6, false), Time{0});
  EXPECT_FALSE(answer->fresh) << "closed until it is released";
  EXPECT_FALSE(rig.module.perform(read(2, 6, true), Time{0})->fresh);
  rig.module.receive(data_frame(0x210, {2}), milliseconds(2));
  rig.module.receive(data_frame(0x210, {3}), milliseconds(3));
  answer = rig.module.perform(read(3, 6, false), Time{0});
  EXPECT_TRUE(answer->fresh);
  EXPECT_EQ(answer->reading.frame, data_frame(0x210, {2}));
  EXPECT_TRUE(answer->reading.overrun);
  EXPECT_EQ(answer->time, milliseconds(2));
  rig.module.receive(data_frame(0x210, {4}), milliseconds(4));
  EXPECT_FALSE(rig.module.perform(read(4, 6, false), Time{0})->fresh) << "locked";
  ObjectOrder ask = read(5, 6, true);
  ask.ask = true;
  EXPECT_EQ(rig.module.perform(ask, Time{0})->refusal, Refusal::none);
  EXPECT_EQ(rig.module.perform(ask, Time{0})->refusal, Refusal::object_pending);
  EXPECT_EQ(rig.hand_over(), remote(data_frame(0x210, {})));
  rig.module.echo(remote(data_frame(0x210, {})), milliseconds(5));
  rig.module.receive(data_frame(0x210, {7}), milliseconds(6));
  EXPECT_EQ(rig.module.perform(read(6, 6, true), Time{0})->reading.frame, data_frame(0x210, {7}));
  EXPECT_EQ(rig.module.perform(read(7, 30, true), Time{0})->refusal, Refusal::object_direction);
  const ObjectState state = rig.module.objects().state(6);
  EXPECT_EQ(state.received, 2u);
  EXPECT_EQ(state.overruns, 1u);
  EXPECT_TRUE(state.open);
}

TEST(ObjectOrders, L43ObjectsThatTellAreEventsOnceEach) {
  Running rig({sender(3, 0x100, Time{0}, true), receiver(6, 0x210, true), receiver(7, 0x211)});
  for (const std::uint8_t number : std::array<std::uint8_t, 2>{6, 7})
    (void)rig.module.perform(read(1, number, true), Time{0});
  rig.module.receive(data_frame(0x211, {}), milliseconds(1));
  rig.module.receive(data_frame(0x210, {5}), milliseconds(2));
  rig.take_job(send(2, 3, data_frame(0x100, {8})));
  rig.module.echo(rig.hand_over(), milliseconds(3));
  const auto first = rig.module.take_event();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->kind, ModuleEvent::Kind::object_received);
  EXPECT_EQ(first->number, 6);
  EXPECT_EQ(first->frame, data_frame(0x210, {5}));
  const auto second = rig.module.take_event();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->kind, ModuleEvent::Kind::object_sent);
  EXPECT_EQ(second->number, 3);
  EXPECT_EQ(second->time, milliseconds(3));
  EXPECT_FALSE(rig.module.take_event());
}

TEST(ObjectOrders, L49TheSendQueueThatBecameEmptyIsToldOnce) {
  Running rig({});
  for (OrderId id = 1; id <= 2; ++id)
    EXPECT_EQ(rig.module.submit({id, data_frame(0x300, {}), milliseconds(100)}, Time{0}), Refusal::none);
  EXPECT_FALSE(rig.module.take_event());
  (void)rig.hand_over();
  EXPECT_FALSE(rig.module.take_event()) << "one waits";
  (void)rig.hand_over();
  const auto event = rig.module.take_event();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, ModuleEvent::Kind::send_queue_empty);
  EXPECT_FALSE(rig.module.take_event());
}

TEST(ObjectOrders, InStopNoJobIsTakenAndOpenOnesEnd) {
  Running rig({sender(3, 0x100)});
  rig.take_job(send(1, 3, data_frame(0x100, {})));
  rig.module.set_running(false, Time{0});
  const auto answers = rig.answers();
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_EQ(answers[0].outcome, Outcome::cancelled);
  EXPECT_EQ(rig.module.perform(send(2, 3, data_frame(0x100, {})), Time{0})->refusal, Refusal::not_running);
  rig.module.set_running(true, Time{0});
  rig.take_job(send(3, 3, data_frame(0x100, {})));
  rig.module.end();
  ASSERT_EQ(rig.answers().size(), 1u);
  EXPECT_EQ(rig.module.perform(send(4, 3, data_frame(0x100, {})), Time{0})->refusal, Refusal::stopped);
}

TEST(ObjectOrders, InStopAnAnswerInTheControllerIsTheLast) {
  Running rig({sender(3, 0x100)});
  ObjectOrder order = send(1, 3, data_frame(0x100, {9}));
  order.job.on_remote = order.job.every_time = true;
  EXPECT_EQ(rig.module.perform(order, Time{0})->outcome, Outcome::done);
  const can::Frame question = remote(data_frame(0x100, {}));
  rig.module.receive(question, milliseconds(1));
  const can::Frame answer = rig.hand_over();
  rig.module.receive(question, milliseconds(2));
  rig.module.set_running(false, milliseconds(3));
  rig.module.echo(answer, milliseconds(4));
  EXPECT_EQ(rig.module.objects().state(3).sent, 1u);
  rig.module.set_running(true, milliseconds(5));
  EXPECT_FALSE(rig.module.next_frame()) << "asked for before the stop";
  rig.module.receive(question, milliseconds(6));
  EXPECT_FALSE(rig.module.next_frame());
}

}  // namespace
}  // namespace layer2
