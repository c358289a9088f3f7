#include "daemon/loop/wall_clock.h"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>

#include "support/silent_bus.h"

namespace cansyncd {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

can::Time bus_clock{};
can::Time offset{};
/// How long the next readings of the wall clock are held up, one after the other.
std::deque<can::Time> held_up;

can::Time read_wall() noexcept {
  bus_clock += microseconds(1);
  const can::Time read = bus_clock + offset;
  if (!held_up.empty()) {
    bus_clock += held_up.front();
    held_up.pop_front();
  }
  bus_clock += microseconds(1);
  return read;
}

class ClockBus final : public test::SilentBus {
 public:
  can::Time now() noexcept override { return bus_clock; }
};

class WallClockTest : public testing::Test {
 protected:
  void SetUp() override {
    bus_clock = seconds(100);
    offset = seconds(1'700'000'000);
    held_up.clear();
    clock.adjust(bus);
  }
  ClockBus bus;
  WallClock clock{&read_wall};
};

TEST_F(WallClockTest, AReadingThatIsHeldUpIsTriedAgain) {
  held_up = {milliseconds(5)};
  clock.adjust(bus);
  EXPECT_EQ(clock.at(bus_clock), bus_clock + offset);
}

TEST_F(WallClockTest, WhereAllAreHeldUpTheFormerOffsetStaysAsLongAsItMayBeRight) {
  held_up = {milliseconds(5), milliseconds(4), milliseconds(6)};
  clock.adjust(bus);
  EXPECT_EQ(clock.at(bus_clock), bus_clock + offset)
      << "times must not go back when the next reading is better";
}

TEST_F(WallClockTest, AClockThatWasSetIsFollowedAlsoByAReadingInDoubt) {
  clock.adjust(bus);
  offset += seconds(3600);
  held_up = {milliseconds(5), milliseconds(4), milliseconds(6)};
  clock.adjust(bus);
  const can::Time wrong = clock.at(bus_clock) - (bus_clock + offset);
  EXPECT_LE(wrong, milliseconds(3));
  EXPECT_GE(wrong, -milliseconds(3));
  clock.adjust(bus);
  EXPECT_EQ(clock.at(bus_clock), bus_clock + offset);
}

TEST_F(WallClockTest, AClockThatDriftsIsFollowed) {
  offset -= microseconds(100);
  clock.adjust(bus);
  EXPECT_EQ(clock.at(bus_clock), bus_clock + offset);
}

}  // namespace
}  // namespace cansyncd
