#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "client/fake_daemon.h"
#include "client/reference_repeater.h"
#include "support/dds_places.h"

namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class RepeaterTest : public ::testing::Test {
 protected:
  /// True when the daemon has got `value` so often.
  bool comes(std::int32_t value, std::ptrdiff_t times) const {
    const auto end = std::chrono::steady_clock::now() + seconds(20);
    while (std::chrono::steady_clock::now() < end) {
      const auto got = daemon.references();
      if (std::count(got.begin(), got.end(), value) >= times) return true;
      std::this_thread::yield();
    }
    return false;
  }

  TwoPlaces places;
  FakeDaemon daemon{places.here};
  Client client = Client::connect({.domain = places.there.domain,
                                   .bus = places.there.partition,
                                   .client_name = "repeater",
                                   .xml = places.there.xml,
                                   .wait = seconds(20)});
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
  const auto end = std::chrono::steady_clock::now() + seconds(20);
  while (daemon.references_gone() == 0 && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_EQ(daemon.references_gone(), 1);
  const std::size_t after = daemon.references().size();
  repeater.set(1, {9, 0, 0, 0}, 1);
  EXPECT_TRUE(client.read(0, 1).ok());
  EXPECT_EQ(daemon.references().size(), after);
}

TEST_F(RepeaterTest, ATelegramWithoutValidValuesIsNotWritten) {
  ReferenceRepeater repeater(client, milliseconds(1));
  repeater.set(3, {1, 1, 1, 1}, 15);
  repeater.set(2, {5, 0, 0, 0}, 1);
  EXPECT_TRUE(comes(5, 3));
  const auto got = daemon.references();
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
  const auto got = daemon.references();
  EXPECT_TRUE(comes(1, std::count(got.begin(), got.end(), 1) + 3));
}

}  // namespace
}  // namespace cansync::client
