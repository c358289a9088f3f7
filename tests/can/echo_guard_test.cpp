#include "can/socketcan/echo_guard.h"

#include <gtest/gtest.h>

namespace can::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr Time kInterval = milliseconds(1);

Frame frame(std::uint32_t id) {
  Frame out;
  out.id = id;
  return out;
}

struct Guarded {
  EchoGuard guard{kInterval};
  bool one_shot = false;

  bool send(std::uint32_t id, Time at) {
    if (!guard.may_send(at)) return false;
    guard.handed_over(frame(id));
    return true;
  }
  void look(Time at, std::initializer_list<std::uint32_t> echoes = {}, bool everything = true) {
    guard.begin_look(at, one_shot);
    for (const std::uint32_t id : echoes) guard.echo(frame(id));
    guard.end_look(everything);
  }
  /// Somebody acknowledges.
  void prove() {
    send(1, Time{0});
    look(microseconds(200), {1});
  }
  /// Two frames at 1 and 1.3 ms that nobody acknowledges, found out.
  void break_down() {
    prove();
    EXPECT_TRUE(send(2, milliseconds(1)));
    EXPECT_TRUE(send(3, microseconds(1300)));
    look(microseconds(1300));
    look(microseconds(2300));
    look(microseconds(3300));
    EXPECT_TRUE(guard.wants_reset());
  }
};

TEST(EchoGuard, OneFrameAtATimeUntilTheFirstEcho) {
  Guarded rig;
  EXPECT_TRUE(rig.send(1, Time{0}));
  EXPECT_FALSE(rig.send(2, microseconds(1)));
  rig.look(microseconds(200), {1});
  EXPECT_TRUE(rig.send(2, microseconds(300)));
  EXPECT_TRUE(rig.send(3, microseconds(301)));
}

TEST(EchoGuard, TheFirstLookAfterwardsDatesAFrame) {
  Guarded rig;
  rig.prove();
  EXPECT_FALSE(rig.guard.wants_time());
  rig.send(2, milliseconds(1));
  // The thread stood still for longer than the frame would be given; nothing had looked for its echo.
  rig.look(milliseconds(50));
  EXPECT_TRUE(rig.send(3, milliseconds(50)));
  rig.look(milliseconds(50) + kInterval - microseconds(101));
  EXPECT_TRUE(rig.send(4, milliseconds(51)));
  rig.look(milliseconds(50) + kInterval - microseconds(100));
  EXPECT_FALSE(rig.send(5, milliseconds(51))) << "looks are not punctual to the microsecond";
}

TEST(EchoGuard, AnIntervalWithoutAnEchoHoldsBackAndALateOneEndsThat) {
  Guarded rig;
  rig.prove();
  EXPECT_TRUE(rig.send(2, milliseconds(1)));
  EXPECT_TRUE(rig.send(3, microseconds(1300)));
  rig.look(microseconds(1500));
  rig.look(microseconds(2000));
  EXPECT_TRUE(rig.send(4, microseconds(2000)));
  rig.look(microseconds(2500));
  EXPECT_FALSE(rig.send(5, microseconds(2500)));
  EXPECT_FALSE(rig.guard.wants_reset());
  EXPECT_EQ(rig.guard.delivery(), Delivery::normal);
  rig.look(microseconds(2600), {2});
  EXPECT_FALSE(rig.send(5, microseconds(2600))) << "two of them stand there still";
  rig.look(microseconds(2700), {3, 4});
  EXPECT_TRUE(rig.send(5, microseconds(2700)));
  EXPECT_EQ(rig.guard.unacknowledged(), 0u);
}

TEST(EchoGuard, AnEchoSpeaksForThoseBeforeItAndAnyEchoForTheBus) {
  Guarded rig;
  rig.prove();
  for (unsigned n = 0; n < 5000; ++n) {
    // Of two frames the echo of the first is lost.
    const Time at = milliseconds(1) + n * kInterval;
    EXPECT_TRUE(rig.send(2, at));
    EXPECT_TRUE(rig.send(3, at));
    rig.look(at + microseconds(500), {3});
  }
}

TEST(EchoGuard, TwoIntervalsWantAResetAndAfterItOneFrameIsTriedAndThenOneASecond) {
  Guarded rig;
  rig.break_down();
  EXPECT_EQ(rig.guard.delivery(), Delivery::unacknowledged);
  rig.guard.emptied(milliseconds(4));
  EXPECT_FALSE(rig.guard.wants_reset());
  EXPECT_EQ(rig.guard.unacknowledged(), 2u);
  EXPECT_TRUE(rig.send(4, milliseconds(5)));
  EXPECT_FALSE(rig.send(5, milliseconds(5)));
  rig.look(milliseconds(5));
  EXPECT_FALSE(rig.guard.wants_reset());
  rig.look(milliseconds(6));
  EXPECT_TRUE(rig.guard.wants_reset()) << "an interval is enough now";
  rig.guard.emptied(milliseconds(7));
  EXPECT_FALSE(rig.send(5, milliseconds(8)));
  EXPECT_TRUE(rig.send(5, milliseconds(7) + EchoGuard::kPause));
  EXPECT_TRUE(rig.guard.wants_time()) << "the pause ends with an echo alone";
  rig.look(milliseconds(7) + EchoGuard::kPause + microseconds(500), {5});
  EXPECT_EQ(rig.guard.delivery(), Delivery::normal);
  EXPECT_EQ(rig.guard.unacknowledged(), 3u);
}

TEST(EchoGuard, WithoutAResetItWaitsForEveryEcho) {
  Guarded rig;
  rig.break_down();
  rig.guard.reset_failed();
  EXPECT_EQ(rig.guard.delivery(), Delivery::not_emptied);
  EXPECT_FALSE(rig.send(4, std::chrono::hours(1)));
  rig.look(std::chrono::hours(1), {2});
  EXPECT_FALSE(rig.send(4, std::chrono::hours(1)));
  rig.look(std::chrono::hours(1) + microseconds(1), {3});
  EXPECT_TRUE(rig.send(4, std::chrono::hours(1) + microseconds(1)));
  EXPECT_EQ(rig.guard.delivery(), Delivery::normal);
}

TEST(EchoGuard, ALookThatLeftFramesBehindDoesNotJudgeNorDoLostOnes) {
  Guarded rig;
  rig.prove();
  for (unsigned n = 1; n < 100; ++n) {
    EXPECT_TRUE(rig.send(n, n * kInterval));
    rig.look(n * kInterval + microseconds(500), {}, false);
  }
  rig.guard.echoes_lost();
  rig.look(std::chrono::seconds(1));
  EXPECT_TRUE(rig.send(2, std::chrono::seconds(1)));
}

TEST(EchoGuard, OneShotGivesUpAndGoesOn) {
  Guarded rig;
  rig.one_shot = true;
  rig.prove();
  for (unsigned n = 1; n < 10; ++n) {
    EXPECT_TRUE(rig.send(2, n * 2 * kInterval));
    rig.look(n * 2 * kInterval);
    rig.look(n * 2 * kInterval + kInterval);
    EXPECT_EQ(rig.guard.unacknowledged(), n);
    EXPECT_EQ(rig.guard.delivery(), n == 1 ? Delivery::normal : Delivery::unacknowledged);
    EXPECT_FALSE(rig.guard.wants_reset());
  }
}

TEST(EchoGuard, OneShotWithAFullQueueIsNone) {
  Guarded rig;
  rig.one_shot = true;
  rig.prove();
  EXPECT_TRUE(rig.send(2, milliseconds(1)));
  rig.look(milliseconds(1));
  rig.look(milliseconds(2));
  rig.guard.queue_full();
  rig.look(microseconds(2100));
  EXPECT_TRUE(rig.guard.wants_reset());
}

TEST(EchoGuard, WithoutAnIntervalItGuardsNothing) {
  EchoGuard guard(Time{0});
  for (unsigned n = 0; n < 100; ++n) {
    guard.handed_over(frame(n));
    guard.begin_look(n * kInterval, false);
    guard.end_look(true);
    EXPECT_TRUE(guard.may_send(n * kInterval));
  }
}

}  // namespace
}  // namespace can::test
