#include <cansync/reference_repeater.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class RepeaterTest : public ::testing::Test {
 protected:
  /// True when the daemon has got `value` so often.
  bool comes(std::int32_t value, std::ptrdiff_t times) const {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (std::chrono::steady_clock::now() < end) {
      const auto got = daemon->references();
      if (std::count(got.begin(), got.end(), value) >= times) return true;
      std::this_thread::yield();
    }
    return false;
  }

  template <class Condition>
  static bool eventually_true(Condition&& condition) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::yield();
    }
    return true;
  }

  TwoPlaces places;
  std::optional<FakeDaemon> daemon{std::in_place, places.here};
  Client client = Client::connect({.domain = places.there.domain,
                                   .bus = places.there.partition,
                                   .client_name = "repeater",
                                   .xml = places.there.xml,
                                   .wait = gateway::kLongWait});
};

TEST_F(RepeaterTest, RepeatsTheNewestValueAndStops) {
  ReferenceRepeater repeater(client, milliseconds(1), 10);
  repeater.set(1, {7, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(7, 5));
  repeater.set(1, {8, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(8, 5));
  EXPECT_EQ(repeater.error(), "");
  repeater.stop();
  repeater.stop();
  // The telegram is given up, and nothing comes any more. A reply comes after what was written before.
  EXPECT_TRUE(comes(8, 5));
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (daemon->references_given_up() == 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::yield();
  EXPECT_EQ(daemon->references_given_up(), 1);
  const std::size_t after = daemon->references().size();
  repeater.set(1, {9, 0, 0, 0}, 1);
  EXPECT_TRUE(client.read(0, 1).ok());
  EXPECT_EQ(daemon->references().size(), after);
}

TEST(ReleaseIntervals, AreThreePeriods) {
  EXPECT_EQ(release_intervals_for(milliseconds(20), milliseconds(1)), 60u);
  EXPECT_EQ(release_intervals_for(milliseconds(3), milliseconds(2)), 5u);
  EXPECT_EQ(release_intervals_for(std::chrono::microseconds(100), milliseconds(8)), 1u);
  EXPECT_EQ(release_intervals_for(std::chrono::hours(10'000), milliseconds(1)), UINT32_MAX);
}

// Else a program that gives values every 20 ms would leave most intervals of 1 ms without any.
TEST_F(RepeaterTest, ValuesAreReleasedForThreePeriodsOrAsLongAsTheProgramSays) {
  const std::chrono::nanoseconds interval(client.master_status().interval_length);
  {
    ReferenceRepeater repeater(client, 25 * std::chrono::duration_cast<std::chrono::microseconds>(interval));
    repeater.set(1, {7, 0, 0, 0}, 1);
    EXPECT_TRUE(comes(7, 1));
    EXPECT_EQ(daemon->released_for(), 75u);
  }
  ReferenceRepeater repeater(client, milliseconds(1), 0, 4);
  repeater.set(1, {8, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(8, 1));
  EXPECT_EQ(daemon->released_for(), 4u);
  EXPECT_THROW(ReferenceRepeater(client, seconds(100)), SetupError);
}

TEST_F(RepeaterTest, ATelegramWithoutValidValuesIsNotWritten) {
  ReferenceRepeater repeater(client, milliseconds(1));
  repeater.set(3, {1, 1, 1, 1}, 15);
  repeater.set(2, {5, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(5, 3));
  const auto got = daemon->references();
  EXPECT_EQ(std::count(got.begin(), got.end(), 5), static_cast<std::ptrdiff_t>(got.size()));
}

// Of two repeaters the stronger one is heard, and the weaker one again when it has gone.
TEST_F(RepeaterTest, StrengthDecides) {
  ReferenceRepeater weak(client, milliseconds(1), 1);
  weak.set(1, {1, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(1, 3));
  ReferenceRepeater strong(client, milliseconds(1), 2);
  strong.set(1, {2, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(2, 50));
  strong.stop();
  const auto got = daemon->references();
  EXPECT_TRUE(comes(1, std::count(got.begin(), got.end(), 1) + 3));
}

// Unregistering alone is a loss: a last sample says before that it is meant.
TEST_F(RepeaterTest, StoppingGivesTheTelegramUpAlsoWhileAWeakerOneLives) {
  ReferenceRepeater weak(client, milliseconds(1), 1);
  weak.set(1, {1, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(1, 3));
  {
    ReferenceRepeater strong(client, milliseconds(1), 2);
    strong.set(1, {2, 0, 0, 0}, 1);
    EXPECT_TRUE(comes(2, 50));
  }
  EXPECT_TRUE(eventually_true([&] { return daemon->references_given_up() == 1; }));
  const auto got = daemon->references();
  EXPECT_TRUE(comes(1, std::count(got.begin(), got.end(), 1) + 3));
}

TEST_F(RepeaterTest, AChangedMappingStopsItUntilItIsTakenUp) {
  ReferenceRepeater repeater(client, milliseconds(1));
  repeater.set(1, {7, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(7, 5));
  daemon->change_mapping();
  EXPECT_TRUE(eventually_true([&] { return repeater.standing() == ReferenceStanding::mapping_changed; }));
  EXPECT_NE(repeater.error().find("take_up"), std::string::npos) << repeater.error();
  const std::size_t before = daemon->references().size();
  repeater.set(1, {8, 0, 0, 0}, 1);
  EXPECT_TRUE(client.read(0, 1).ok());
  EXPECT_EQ(daemon->references().size(), before);
  repeater.take_up();
  repeater.set(1, {9, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(9, 5));
  EXPECT_EQ(repeater.standing(), ReferenceStanding::current);
  const auto got = daemon->references();
  EXPECT_EQ(std::count(got.begin(), got.end(), 8), 0);
}

// The program looks at the line before it takes up: what comes in between is not what it looked at.
TEST_F(RepeaterTest, AMappingThatCameAfterTheLookIsNotTakenUp) {
  ReferenceRepeater repeater(client, milliseconds(1));
  const Validity looked_at = client.validity();
  daemon->change_mapping();
  ASSERT_TRUE(eventually_true([&] { return repeater.standing() == ReferenceStanding::mapping_changed; }));
  repeater.take_up(looked_at);
  repeater.set(1, {8, 0, 0, 0}, 1);
  EXPECT_TRUE(eventually_true([&] { return repeater.standing() == ReferenceStanding::mapping_changed; }));
  EXPECT_TRUE(client.read(0, 1).ok());
  EXPECT_EQ(daemon->references().size(), 0u);
  repeater.take_up(client.validity());
  repeater.set(1, {9, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(9, 5));
}

// A daemon that was started anew gets nothing from a program that was not told to.
TEST_F(RepeaterTest, ANewStartOfTheDaemonGetsNothingUntilItIsTakenUp) {
  ReferenceWriter writer(client);
  EXPECT_EQ(writer.write(2, {5, 0, 0, 0}, 1), "");
  ReferenceRepeater repeater(client, milliseconds(1), 3);
  repeater.set(1, {7, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(7, 5));
  daemon.reset();
  daemon.emplace(places.here);
  EXPECT_TRUE(eventually_true([&] { return repeater.standing() == ReferenceStanding::daemon_restarted; }));
  EXPECT_NE(repeater.error().find("started anew"), std::string::npos) << repeater.error();
  EXPECT_EQ(writer.standing(), ReferenceStanding::daemon_restarted);
  EXPECT_TRUE(eventually_true([&] {
    return writer.write(2, {6, 0, 0, 0}, 1).find("started anew") != std::string::npos;
  }));
  repeater.set(1, {8, 0, 0, 0}, 1);
  EXPECT_TRUE(eventually_true([&] { return client.read(0, 1).ok(); }));
  EXPECT_EQ(daemon->references().size(), 0u);

  repeater.take_up();
  repeater.set(1, {9, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(9, 5));
  EXPECT_EQ(repeater.error(), "");
  writer.take_up();
  EXPECT_EQ(writer.write(2, {10, 0, 0, 0}, 1), "");
  EXPECT_TRUE(comes(10, 1));
  const auto got = daemon->references();
  for (const std::int32_t old : {5, 6, 7, 8}) EXPECT_EQ(std::count(got.begin(), got.end(), old), 0) << old;
}

}  // namespace
}  // namespace cansync::client
