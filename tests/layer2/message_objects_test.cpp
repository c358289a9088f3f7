#include "layer2/message_objects.h"

#include <gtest/gtest.h>

#include <chrono>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using std::chrono::milliseconds;

ObjectSettings sends(std::uint32_t identifier, Time timeout = Time{0}) {
  return {{.identifier = identifier}, true, timeout};
}
ObjectSettings receives(std::uint32_t identifier, std::uint32_t mask = 0x7FF) {
  return {{.identifier = identifier, .mask = mask}, false, Time{0}};
}
ObjectJob job(const can::Frame& frame, bool on_remote = false, bool every_time = false) {
  return {frame, on_remote, every_time};
}

TEST(MessageObjects, L33TheMaskSaysWhichBitsCount) {
  // The example of the manual: 0x124 to 0x127 and 0x134 to 0x137.
  const MaskRule rule{.identifier = 0x137, .mask = 0x7EC};
  for (std::uint32_t id = 0; id <= 0x7FF; ++id) {
    const bool wanted = (id >= 0x124 && id <= 0x127) || (id >= 0x134 && id <= 0x137);
    EXPECT_EQ(takes(rule, data_frame(id, {})), wanted) << id;
  }
  EXPECT_FALSE(takes(rule, extended(data_frame(0x137, {}))));
  EXPECT_FALSE(takes({.identifier = 0, .mask = 0}, can::test::error(data_frame(1, {}))));
  EXPECT_TRUE(takes({.identifier = 0, .mask = 0, .extended = true}, extended(data_frame(0x1FFFFFFF, {}))));
  EXPECT_FALSE(takes({.identifier = 0x18DAF110, .mask = 0xFFFFFFFF, .extended = true},
                     extended(data_frame(0x18DAF111, {}))));
}

TEST(MessageObjects, L34TheLaterConfigurationWins) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(3, sends(0x100)), ObjectProblem::none);
  ASSERT_EQ(objects.start(3, job(data_frame(0x100, {1})), Time{0}), ObjectProblem::none);
  ASSERT_EQ(objects.configure(3, sends(0x101)), ObjectProblem::none);
  EXPECT_FALSE(objects.next());
  EXPECT_EQ(objects.take_state(3), JobState::aborted);
  ASSERT_EQ(objects.configure(3, receives(0x101)), ObjectProblem::none);
  EXPECT_EQ(objects.start(3, job(data_frame(0x101, {})), Time{0}), ObjectProblem::direction);
  EXPECT_EQ(objects.configure(32, sends(1)), ObjectProblem::number);
  EXPECT_EQ(objects.configure(1, sends(0x800)), ObjectProblem::frame);
  EXPECT_EQ(objects.release(4), ObjectProblem::direction);  // not configured
  objects.reset();
  EXPECT_EQ(objects.release(3), ObjectProblem::direction);
}

TEST(MessageObjects, L35AJobIsDoneOnce) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(0, sends(0x100)), ObjectProblem::none);
  EXPECT_EQ(objects.take_state(0), JobState::none);
  ASSERT_EQ(objects.start(0, job(data_frame(0x123, {1, 2})), Time{0}), ObjectProblem::none);
  EXPECT_EQ(objects.take_state(0), JobState::under_way);
  EXPECT_EQ(objects.start(0, job(data_frame(0x124, {})), Time{0}), ObjectProblem::pending);
  ASSERT_EQ(objects.next(), 0u);
  EXPECT_EQ(objects.frame(0), data_frame(0x123, {1, 2}));  // its identifier overrides that of the object
  const std::uint32_t handing = objects.handed_over(0);
  EXPECT_FALSE(objects.next());
  EXPECT_EQ(objects.take_state(0), JobState::under_way);
  EXPECT_FALSE(objects.sent(0, handing + 1));  // another frame
  EXPECT_TRUE(objects.sent(0, handing));
  EXPECT_EQ(objects.take_state(0), JobState::done);
  EXPECT_EQ(objects.take_state(0), JobState::none);
  EXPECT_EQ(objects.start(0, job(extended(data_frame(0x123, {}))), Time{0}), ObjectProblem::frame);
  EXPECT_EQ(objects.start(0, job(data_frame(0x800, {})), Time{0}), ObjectProblem::frame);
}

TEST(MessageObjects, L36AJobIsTakenBack) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(0, sends(0x100)), ObjectProblem::none);
  EXPECT_FALSE(objects.abort(0));
  ASSERT_EQ(objects.start(0, job(data_frame(0x100, {})), Time{0}), ObjectProblem::none);
  EXPECT_TRUE(objects.abort(0));
  EXPECT_EQ(objects.take_state(0), JobState::aborted);
  EXPECT_FALSE(objects.next());
  ASSERT_EQ(objects.start(0, job(data_frame(0x100, {})), Time{0}), ObjectProblem::none);
  objects.handed_over(0);
  EXPECT_FALSE(objects.abort(0));  // it may be on the bus
}

TEST(MessageObjects, L37AJobTimesOut) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(0, sends(0x100, milliseconds(10))), ObjectProblem::none);
  ASSERT_EQ(objects.start(0, job(data_frame(0x100, {})), milliseconds(5)), ObjectProblem::none);
  EXPECT_EQ(objects.next_deadline(), milliseconds(15));
  objects.advance(milliseconds(15) - Time{1});
  EXPECT_EQ(objects.take_state(0), JobState::under_way);
  objects.advance(milliseconds(15));
  EXPECT_EQ(objects.take_state(0), JobState::timed_out);
  EXPECT_FALSE(objects.next());
  EXPECT_EQ(objects.next_deadline(), Time::max());
}

TEST(MessageObjects, L38ARemoteFrameIsAnsweredOnce) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(2, sends(0x100)), ObjectProblem::none);
  ASSERT_EQ(objects.start(2, job(data_frame(0x100, {9}), true), Time{0}), ObjectProblem::none);
  EXPECT_FALSE(objects.next());
  EXPECT_FALSE(objects.receive(remote(data_frame(0x101, {}))));
  EXPECT_FALSE(objects.next());
  // Nobody asks: another job takes its place.
  ASSERT_EQ(objects.start(2, job(data_frame(0x100, {8}), true), Time{0}), ObjectProblem::none);
  EXPECT_FALSE(objects.receive(remote(data_frame(0x100, {}))));
  ASSERT_EQ(objects.next(), 2u);
  EXPECT_EQ(objects.frame(2), data_frame(0x100, {8}));
  EXPECT_TRUE(objects.sent(2, objects.handed_over(2)));
  EXPECT_EQ(objects.take_state(2), JobState::done);
  EXPECT_EQ(objects.state(2).job_number, 2u);
  EXPECT_EQ(objects.state(2).job_sent, 1u);
  (void)objects.receive(remote(data_frame(0x100, {})));
  EXPECT_FALSE(objects.next());
  ASSERT_EQ(objects.start(2, job(data_frame(0x100, {7}), true), Time{0}), ObjectProblem::none);
  EXPECT_EQ(objects.state(2).job_number, 3u);
  EXPECT_EQ(objects.state(2).job_sent, 0u) << "what the one before sent is not of this job";
  EXPECT_EQ(objects.state(2).sent, 1u);
}

TEST(MessageObjects, L38ARemoteFrameIsAnsweredEachTime) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(2, sends(0x100)), ObjectProblem::none);
  ASSERT_EQ(objects.start(2, job(data_frame(0x100, {9}), true, true), Time{0}), ObjectProblem::none);
  for (int i = 0; i < 3; ++i) {
    (void)objects.receive(remote(data_frame(0x100, {})));
    ASSERT_EQ(objects.next(), 2u);
    EXPECT_TRUE(objects.sent(2, objects.handed_over(2)));
    EXPECT_EQ(objects.take_state(2), JobState::done);
    EXPECT_EQ(objects.take_state(2), JobState::under_way);
  }
  // Asked again while the answer is on its way.
  (void)objects.receive(remote(data_frame(0x100, {})));
  const std::uint32_t handing = objects.handed_over(2);
  (void)objects.receive(remote(data_frame(0x100, {})));
  EXPECT_TRUE(objects.sent(2, handing));
  EXPECT_EQ(objects.next(), 2u);
  EXPECT_EQ(objects.state(2).job_sent, 4u);
}

TEST(MessageObjects, L39TheLowestNumberSendsFirst) {
  MessageObjects objects;
  for (const unsigned number : {7u, 3u, 12u}) {
    ASSERT_EQ(objects.configure(number, sends(0)), ObjectProblem::none);
    // The higher the number, the better its identifier would be.
    ASSERT_EQ(objects.start(number, job(data_frame(0x700 - number, {})), Time{0}), ObjectProblem::none);
  }
  for (const unsigned number : {3u, 7u, 12u}) {
    ASSERT_EQ(objects.next(), number);
    objects.handed_over(number);
  }
  EXPECT_FALSE(objects.next());
}

TEST(MessageObjects, L40AnObjectReceivesWhenItIsReleased) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(5, receives(0x200)), ObjectProblem::none);
  EXPECT_FALSE(objects.receive(data_frame(0x200, {1})));  // closed
  ASSERT_EQ(objects.release(5), ObjectProblem::none);
  EXPECT_FALSE(objects.read(5, false));  // open and empty: it stays open
  ASSERT_EQ(objects.receive(data_frame(0x200, {2})), 5u);
  auto reading = objects.read(5, false);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->frame, data_frame(0x200, {2}));
  EXPECT_FALSE(reading->overrun);
  EXPECT_FALSE(objects.receive(data_frame(0x200, {3})));  // locked
  ASSERT_EQ(objects.release(5), ObjectProblem::none);
  ASSERT_EQ(objects.receive(data_frame(0x200, {4})), 5u);
  ASSERT_TRUE(objects.read(5, true));
  ASSERT_EQ(objects.receive(data_frame(0x200, {5})), 5u);  // opened anew by the reading
  reading = objects.read(5, true);
  EXPECT_EQ(reading->frame, data_frame(0x200, {5}));
  EXPECT_FALSE(reading->overrun);
}

TEST(MessageObjects, L41AnOverrunGoesOnToTheNextAndIsToldOnce) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(1, receives(0x200)), ObjectProblem::none);
  ASSERT_EQ(objects.configure(9, receives(0, 0)), ObjectProblem::none);
  for (const unsigned number : {1u, 9u}) ASSERT_EQ(objects.release(number), ObjectProblem::none);
  EXPECT_EQ(objects.receive(data_frame(0x200, {1})), 1u);
  EXPECT_EQ(objects.receive(data_frame(0x200, {2})), 9u);
  EXPECT_FALSE(objects.receive(data_frame(0x200, {3})));
  const auto first = objects.read(1, true);
  EXPECT_EQ(first->frame, data_frame(0x200, {1}));  // the older one is kept
  EXPECT_TRUE(first->overrun);
  EXPECT_EQ(objects.receive(data_frame(0x200, {4})), 1u);
  EXPECT_FALSE(objects.read(1, false)->overrun);
}

TEST(MessageObjects, L42AReleaseCanAskForTheFrame) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(6, receives(0x210)), ObjectProblem::none);
  ASSERT_EQ(objects.release(6, true), ObjectProblem::none);
  ASSERT_EQ(objects.next(), 6u);
  EXPECT_EQ(objects.frame(6), remote(data_frame(0x210, {})));
  EXPECT_EQ(objects.release(6, true), ObjectProblem::pending);
  EXPECT_TRUE(objects.sent(6, objects.handed_over(6)));
  ASSERT_EQ(objects.receive(data_frame(0x210, {7})), 6u);
  EXPECT_EQ(objects.read(6, false)->frame, data_frame(0x210, {7}));
  ASSERT_EQ(objects.release(6, true), ObjectProblem::none);
  EXPECT_EQ(objects.next(), 6u);
}

TEST(MessageObjects, L59WhatIsReservedBelongsToAnotherService) {
  MessageObjects objects;
  objects.reserve(28);
  EXPECT_EQ(objects.configure(28, sends(1)), ObjectProblem::reserved);
  EXPECT_EQ(objects.start(28, job(data_frame(1, {})), Time{0}), ObjectProblem::reserved);
  EXPECT_EQ(objects.release(28), ObjectProblem::reserved);
  objects.reset();
  EXPECT_EQ(objects.configure(28, sends(1)), ObjectProblem::reserved);
}

TEST(MessageObjects, WhatTheControllerLostHasTimedOut) {
  MessageObjects objects;
  ASSERT_EQ(objects.configure(0, sends(0x100)), ObjectProblem::none);
  ASSERT_EQ(objects.start(0, job(data_frame(0x100, {})), Time{0}), ObjectProblem::none);
  objects.handed_over(0);
  objects.controller_emptied();
  EXPECT_EQ(objects.take_state(0), JobState::timed_out);
  EXPECT_EQ(objects.start(0, job(data_frame(0x100, {})), Time{0}), ObjectProblem::none);
}

}  // namespace
}  // namespace layer2
