#include "daemon/cansync/gateway/reference_age.h"

#include <gtest/gtest.h>

#include <optional>

#include "support/loop_rig.h"

/// Values that grow old on their way to the bus, in virtual time: however long and wherever they wait, the
/// release of values older than the limit never begins.
namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using can::Time;
using std::chrono::milliseconds;
using SteadyTime = std::chrono::steady_clock::time_point;

constexpr milliseconds kLimit{20};
constexpr unsigned kWritten =
    100;  ///< SYNC number about which the values are written; the line is active by then
constexpr std::uint16_t kValue = 77;

/// How long each stage holds the values up, and how long they are to be released.
struct Delays {
  Time phase{};    ///< after SYNC `kWritten`, when they are written
  Time cache{};    ///< in the reader, before the gateway takes them
  Time gateway{};  ///< between the gateway's look at their age and the ring
  Time line{};     ///< the realtime thread sleeps so much longer, once, from when they are in the ring
  std::uint32_t release = 1;
  std::optional<unsigned> ahead = {};  ///< from_interval: so many intervals after the one they are written in
};

struct Course {
  Time written{};
  std::optional<Time> first;  ///< when their release began, after they were written
  bool refused = false;       ///< by the gateway or the realtime thread
  bool told = false;          ///< event references_too_old
};

/// One value on its way through every stage. The wall clock is the bus's, so a source time is an instant.
Course course(const Delays& delays) {
  LoopRig rig;
  Course course;
  ReferenceAge age(kLimit, rig.interval);
  Time late{0};
  rig.bus.lateness = [&](Time) { return std::exchange(late, Time{0}); };
  rig.at(kWritten, delays.phase, [&] { course.written = rig.bus.now(); });
  cansync::ReferenceUpdate update = references(cansync::Channel::one, delays.release);
  update.value[0] = kValue;
  rig.at(kWritten, delays.phase + delays.cache, [&] {
    const MasterSnapshot heard = rig.snapshot();
    age.set_line(heard.when);
    const Time now = rig.bus.now();
    const auto verdict = age.judge(course.written.count(), {SteadyTime(now), now.count()});
    course.refused = verdict.problem.has_value();
    update.too_old_from = verdict.too_old_from;
    if (delays.ahead) update.from_interval = heard.when.interval + *delays.ahead;
  });
  rig.at(kWritten, delays.phase + delays.cache + delays.gateway, [&] {
    if (course.refused) return;
    EXPECT_TRUE(rig.exchange.requests.try_push(update));
    late = delays.line;
  });
  rig.run_until(kWritten + 150);
  for (const auto& sent : rig.bus.sent) {
    const auto decoded = cansync::decode(sent.frame);
    const auto* telegram = std::get_if<cansync::Telegram>(&decoded);
    const auto* reference = telegram != nullptr ? std::get_if<cansync::ReferenceTelegram>(telegram) : nullptr;
    if (reference == nullptr || reference->word[0] != kValue || course.first) continue;
    course.first = sent.at - course.written;
  }
  course.refused = course.refused || !rig.reported<ReferenceRefused>().empty();
  for (const EventReport& report : rig.reported<EventReport>()) {
    course.told = course.told || report.event.code == cansync::MasterEvent::Code::references_too_old;
  }
  return course;
}

/// Every length of a suspension up to twice the limit, at every phase of an interval, at one stage.
void expect_never_old(Time Delays::*stage, std::uint32_t release, std::optional<unsigned> ahead = {}) {
  const Time interval = cansync::slot_times(cansync::BitRate::mbit1).interval;
  unsigned begun = 0;
  for (Time phase{0}; phase < interval; phase += interval / 8) {
    for (Time length{0}; length <= 2 * kLimit; length += interval / 4) {
      Delays delays{.phase = phase, .release = release, .ahead = ahead};
      delays.*stage = length;
      const Course seen = course(delays);
      SCOPED_TRACE(::testing::Message()
                   << "phase " << phase.count() << " ns, length " << length.count() << " ns");
      if (seen.first) {
        ++begun;
        ASSERT_LE(*seen.first, Time(kLimit));
      }
      // Values for one interval are gone with it when the thread came too late for their slot.
      if (stage == &Delays::line && release == 1) continue;
      if (!seen.first) {
        ASSERT_TRUE(seen.refused || seen.told) << "what is not released is told";
      }
      if (length + 3 * interval < Time(kLimit)) {
        ASSERT_TRUE(seen.first) << "young values are released";
      }
    }
  }
  EXPECT_GT(begun, 0U);
}

TEST(ReferenceAge, ValuesThatGrewOldInTheReaderAreNotReleased) {
  expect_never_old(&Delays::cache, 1);
}
TEST(ReferenceAge, ValuesThatGrewOldBeforeTheRingAreNotReleased) {
  expect_never_old(&Delays::gateway, 1);
}
TEST(ReferenceAge, ValuesThatGrewOldOnTheirWayToTheBusAreNotReleased) {
  expect_never_old(&Delays::line, 1);
}
TEST(ReferenceAge, NorWhenTheyAreForManyIntervals) {
  expect_never_old(&Delays::cache, 1000);
  expect_never_old(&Delays::gateway, 1000);
  expect_never_old(&Delays::line, 1000);
}

/// Values for a later interval wait for it; a suspension beyond it makes them late, and too old by the limit.
TEST(ReferenceAge, ValuesForALaterIntervalMayWaitForItButNotLonger) {
  const Time interval = cansync::slot_times(cansync::BitRate::mbit1).interval;
  for (const unsigned ahead : {5U, 60U}) {
    for (Time length{0}; length <= 4 * kLimit; length += interval / 2) {
      const Course seen = course({.line = length, .release = 1000, .ahead = ahead});
      SCOPED_TRACE(::testing::Message() << ahead << " ahead, length " << length.count() << " ns");
      const Time asked = ahead * interval;
      if (seen.first) {
        EXPECT_LE(*seen.first, std::max(Time(kLimit), asked + interval));
      }
      const Time bound = std::max(Time(kLimit), asked);
      if (length + 2 * interval < bound) {
        EXPECT_TRUE(seen.first);
      }
      if (length > bound + interval) {
        EXPECT_FALSE(seen.first);
      }
    }
  }
}

// --- the number of the interval

constexpr Time kInterval = milliseconds(1);

ReferenceAge heard_at(std::uint64_t interval, Time bus) {
  ReferenceAge age(kLimit, kInterval);
  age.set_line({interval, bus, Time{0}});
  return age;
}

TEST(ReferenceAge, TellsTheFirstIntervalThatBeginsTooLate) {
  const ReferenceAge age = heard_at(1000, milliseconds(5000));
  const auto from = [&](Time now, Time age_now) {
    return age.judge(0, {SteadyTime(now), age_now.count()}).too_old_from;
  };
  EXPECT_EQ(from(milliseconds(5000), Time{0}), 1021U);
  EXPECT_EQ(from(milliseconds(5000), kLimit), 1001U);
  EXPECT_EQ(from(milliseconds(5000) - Time(1), kLimit), 1000U);
  EXPECT_EQ(from(milliseconds(5003), milliseconds(19)), 1005U);
  EXPECT_EQ(from(milliseconds(4000), milliseconds(20)), 1U)
      << "the line was heard of much later: over already";
  EXPECT_EQ(from(milliseconds(3000), milliseconds(20)), 1U) << "0 would be no limit";
}

TEST(ReferenceAge, ASuspensionBetweenBothClocksMakesValuesOlder) {
  const ReferenceAge age = heard_at(1000, milliseconds(5000));
  // 3 ms old when the steady clock was read, 13 ms when the wall clock was.
  const auto verdict = age.judge(0, {SteadyTime(milliseconds(5000)), Time(milliseconds(13)).count()});
  EXPECT_FALSE(verdict.problem);
  EXPECT_EQ(verdict.too_old_from, 1008U);
}

TEST(ReferenceAge, TheLimitIsExactOnBothSides) {
  const ReferenceAge age = heard_at(1000, milliseconds(5000));
  const auto problem = [&](std::int64_t source) {
    return age.judge(source, {SteadyTime(milliseconds(5000)), 0}).problem;
  };
  const std::int64_t limit = Time(kLimit).count();
  EXPECT_FALSE(problem(-limit));
  EXPECT_FALSE(problem(limit));
  EXPECT_TRUE(problem(-limit - 1));
  EXPECT_TRUE(problem(limit + 1));
  EXPECT_TRUE(problem(INT64_MIN)) << "a peer may write anything";
  EXPECT_TRUE(problem(INT64_MAX));
}

TEST(ReferenceAge, WithoutALimitNothingIsTooOld) {
  ReferenceAge age = heard_at(1000, milliseconds(5000));
  age.set_limit(milliseconds(0));
  const auto verdict = age.judge(INT64_MIN, {SteadyTime(milliseconds(5000)), 0});
  EXPECT_FALSE(verdict.problem);
  EXPECT_EQ(verdict.too_old_from, 0U);
}

}  // namespace
