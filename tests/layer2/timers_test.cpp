#include "layer2/timers.h"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <vector>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using std::chrono::microseconds;
using std::chrono::milliseconds;

TimerSettings every(Time period, Time phase = Time{0}) {
  TimerSettings settings;
  settings.frame = data_frame(0x80, {});
  settings.period = period;
  settings.phase = phase;
  return settings;
}

/// The instants at which a timer's frames are handed over until `end`, without lateness.
std::map<unsigned, std::vector<Time>> run(Timers& timers, Time end, Time lateness = Time{0}) {
  std::map<unsigned, std::vector<Time>> sent;
  while (timers.next_deadline() < end) {
    const Time now = timers.next_deadline() + lateness;
    timers.advance(now);
    while (const auto due = timers.due()) {
      sent[*due].push_back(now);
      timers.taken(*due);
    }
  }
  return sent;
}

TEST(Timers, L11SixteenTimersSendAtTheirPeriodAndPhase) {
  Timers timers;
  for (unsigned number = 1; number <= Timers::kMost; ++number) {
    ASSERT_TRUE(timers.configure(number, every(milliseconds(number), microseconds(100 * number))));
    ASSERT_TRUE(timers.start(number, milliseconds(5)));
  }
  const auto sent = run(timers, milliseconds(1005));
  for (unsigned number = 1; number <= Timers::kMost; ++number) {
    const auto& times = sent.at(number);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const auto n = static_cast<Time::rep>(i);
      EXPECT_EQ(times[i], milliseconds(5) + microseconds(100 * number) + n * milliseconds(number));
    }
    EXPECT_GE(times.size(), 1000u / number - 1);
    EXPECT_EQ(timers.sent(number), times.size());
    EXPECT_EQ(timers.left_out(number), 0u);
  }
}

TEST(Timers, L11LatenessDoesNotAddUp) {
  Timers timers;
  ASSERT_TRUE(timers.configure(1, every(milliseconds(1))));
  ASSERT_TRUE(timers.start(1, Time{0}));
  const auto sent = run(timers, std::chrono::minutes(1), microseconds(70)).at(1);
  ASSERT_EQ(sent.size(), 60000u);
  EXPECT_EQ(sent.back(), milliseconds(59999) + microseconds(70));
}

TEST(Timers, L11AOneShotTimerSendsOnce) {
  Timers timers;
  TimerSettings once = every(milliseconds(1), milliseconds(3));
  once.cyclic = false;
  ASSERT_TRUE(timers.configure(4, once));
  ASSERT_TRUE(timers.start(4, Time{0}));
  EXPECT_EQ(run(timers, milliseconds(100)).at(4), std::vector<Time>{milliseconds(3)});
  EXPECT_FALSE(timers.running(4));
  ASSERT_TRUE(timers.start(4, milliseconds(200)));
  EXPECT_EQ(run(timers, milliseconds(300)).at(4), std::vector<Time>{milliseconds(203)});
}

TEST(Timers, L11WhatWentByIsLeftOutAndCounted) {
  Timers timers;
  ASSERT_TRUE(timers.configure(1, every(milliseconds(10))));
  ASSERT_TRUE(timers.start(1, Time{0}));
  timers.advance(Time{0});
  EXPECT_EQ(timers.due(), 1u);  // the bus does not take it
  timers.advance(milliseconds(10));
  EXPECT_EQ(timers.left_out(1), 1u);
  timers.advance(milliseconds(35));
  EXPECT_EQ(timers.left_out(1), 3u);
  timers.taken(1);
  EXPECT_FALSE(timers.due());
  EXPECT_EQ(timers.next_deadline(), milliseconds(40));
  EXPECT_EQ(timers.sent(1), 1u);
}

TEST(Timers, L11TheContentChangesWhileATimerRuns) {
  Timers timers;
  ASSERT_TRUE(timers.configure(2, every(milliseconds(10))));
  ASSERT_TRUE(timers.start(2, Time{0}));
  timers.advance(Time{0});
  timers.taken(2);
  ASSERT_TRUE(timers.set_frame(2, data_frame(0x81, {7})));
  EXPECT_EQ(timers.next_deadline(), milliseconds(10));
  EXPECT_EQ(timers.settings(2).frame, data_frame(0x81, {7}));
  TimerSettings same = every(milliseconds(10));
  ASSERT_TRUE(timers.configure(2, same));
  EXPECT_TRUE(timers.running(2));
  same.period = milliseconds(20);
  ASSERT_TRUE(timers.configure(2, same));
  EXPECT_FALSE(timers.running(2));
}

TEST(Timers, L12TheyAreStartedAndStopped) {
  Timers timers;
  EXPECT_FALSE(timers.start(1, Time{0}));  // it sends nothing yet
  EXPECT_FALSE(timers.start(0, Time{0}));
  EXPECT_FALSE(timers.start(17, Time{0}));
  EXPECT_FALSE(timers.stop(17));
  EXPECT_FALSE(timers.set_frame(1, {}));
  EXPECT_FALSE(timers.configure(1, every(Time{0})));
  ASSERT_TRUE(timers.configure(16, every(milliseconds(10))));
  ASSERT_TRUE(timers.start(16, Time{0}));
  timers.advance(Time{0});
  ASSERT_TRUE(timers.stop(16));
  EXPECT_FALSE(timers.due());
  EXPECT_EQ(timers.next_deadline(), Time::max());
  EXPECT_TRUE(timers.stop(16));
}

TEST(Timers, L11WhatIsDueLongestGoesFirst) {
  Timers timers;
  ASSERT_TRUE(timers.configure(1, every(milliseconds(10), milliseconds(2))));
  ASSERT_TRUE(timers.configure(9, every(milliseconds(10), milliseconds(1))));
  for (const unsigned number : {1u, 9u}) ASSERT_TRUE(timers.start(number, Time{0}));
  timers.advance(milliseconds(5));
  EXPECT_EQ(timers.due(), 9u);
  timers.taken(9);
  EXPECT_EQ(timers.due(), 1u);
}

constexpr WindowSettings kWindow{true, milliseconds(10), milliseconds(2), milliseconds(5), true};

TEST(SyncWindow, L13OpensBetweenItsPhasesFromTheStartOfTimer1On) {
  SyncWindow window(kWindow);
  EXPECT_TRUE(window.open(Time{0}, Time{0}));  // it does not run
  EXPECT_EQ(window.next_opening(Time{0}), Time::max());
  window.timer_started(1, milliseconds(100));
  EXPECT_FALSE(window.runs());
  window.timer_started(2, milliseconds(100));
  ASSERT_TRUE(window.runs());
  EXPECT_FALSE(window.open(milliseconds(100), Time{0}));
  EXPECT_EQ(window.next_opening(milliseconds(100)), milliseconds(102));
  EXPECT_TRUE(window.open(milliseconds(102), milliseconds(1)));
  EXPECT_EQ(window.next_opening(milliseconds(102)), milliseconds(112));
  EXPECT_TRUE(window.open(milliseconds(124), milliseconds(1)));
  EXPECT_FALSE(window.open(milliseconds(124), milliseconds(1) + Time{1}));  // it would end outside
  EXPECT_FALSE(window.open(milliseconds(125), Time{1}));
}

TEST(SyncWindow, L13NeedsBothTimersStartedOneDirectlyAfterTheOther) {
  SyncWindow window(kWindow);
  window.timer_started(1, Time{0});
  window.timer_started(3, Time{0});
  window.timer_started(2, Time{0});
  EXPECT_FALSE(window.runs());
  window.timer_started(2, Time{0});
  window.timer_started(1, Time{0});
  EXPECT_FALSE(window.runs());
  window.timer_started(2, milliseconds(1));
  EXPECT_TRUE(window.runs());
  window.timer_stopped(2);
  EXPECT_FALSE(window.runs());
  SyncWindow unused(WindowSettings{});
  unused.timer_started(1, Time{0});
  unused.timer_started(2, Time{0});
  EXPECT_FALSE(unused.runs());
}

TEST(SyncWindow, L13ItsPhasesAreChecked) {
  EXPECT_EQ(check(kWindow), WindowProblem::none);
  WindowSettings wrong = kWindow;
  wrong.repeat = Time{0};
  EXPECT_EQ(check(wrong), WindowProblem::repeat_not_over_zero);
  wrong = kWindow;
  wrong.end = wrong.begin;
  EXPECT_EQ(check(wrong), WindowProblem::end_not_after_begin);
  wrong = kWindow;
  wrong.end = milliseconds(11);
  EXPECT_EQ(check(wrong), WindowProblem::end_after_repeat);
}

}  // namespace
}  // namespace layer2
