#include "daemon/cansync_slave/realtime/release_store.h"

#include <gtest/gtest.h>

#include "cansync/settings/timing.h"
#include "silent_application.h"

namespace cansyncd {
namespace {

using cansync::Channel;
using cansync::LeadAxis;
using cansync::LeadSource;

/// A gateway whose lower reference values 0 and 4 are its actual values 0 and 1.
class ReleaseForTheLowerBus : public testing::Test {
 protected:
  static cansync::LeadSources sources() {
    cansync::LeadSources out;
    out[0] = {.kind = LeadSource::Kind::actual, .value = 0};
    out[4] = {.kind = LeadSource::Kind::actual, .value = 1};
    return out;
  }
  ReleaseForTheLowerBus() {
    for (const auto command :
         {cansync::ControlCommand::handshake, cansync::ControlCommand::take_over_initialisation,
          cansync::ControlCommand::start_synchronous, cansync::ControlCommand::enable_active})
      (void)slave.control(command);
  }
  void edge(std::uint64_t passed = 1) {
    store.interval_ends(slave, passed);
    slave.on_sync(passed);
    now += passed;
    axis.begin_interval(now);
    store.interval_begins(slave);
  }
  void release(std::uint8_t valid, std::uint32_t first, std::uint32_t second, std::uint32_t intervals = 100) {
    store.take({Channel::one, {first, second}, valid, intervals}, slave);
  }
  /// What the lower telegram of value 0 (or, of channel two, value 4) gets.
  std::optional<std::uint32_t> given(Channel channel) {
    const auto update = axis.take(channel);
    return update ? std::optional(update->value[0]) : std::nullopt;
  }

  test::SilentApplication nobody;
  cansync::Slave slave{{}, nobody};
  LeadAxis axis{sources(), cansync::BitRate::mbit1, std::chrono::microseconds(50), cansync::Duration{0}};
  ReleaseStore store{&axis};
  cansync::IntervalNumber now = 0;
};

TEST_F(ReleaseForTheLowerBus, GivesEachValueOnceAtTheNextEdge) {
  release(0b0011, 7, 8);
  edge();
  EXPECT_EQ(given(Channel::one), 7u);
  EXPECT_EQ(given(Channel::two), 8u);
  edge();
  EXPECT_FALSE(given(Channel::one));
  EXPECT_FALSE(given(Channel::two));
}

TEST_F(ReleaseForTheLowerBus, GivesNoOlderValueInThePlaceOfOneThatWasNotReleased) {
  release(0b0011, 7, 8);
  edge();
  release(0b0001, 9, 0);
  edge();
  EXPECT_EQ(given(Channel::one), 9u);
  EXPECT_FALSE(given(Channel::two)) << "8 is of the interval before";
}

TEST_F(ReleaseForTheLowerBus, GivesNothingThatWasWithdrawn) {
  release(0b0011, 7, 8);
  release(0b0011, 7, 8, 0);
  edge();
  EXPECT_FALSE(given(Channel::one));
}

TEST_F(ReleaseForTheLowerBus, GivesNothingOverIntervalsThatWereSkipped) {
  release(0b0011, 7, 8);
  edge(3);
  EXPECT_FALSE(given(Channel::one));
}

/// A withdrawal after the edge that began the running interval.
TEST_F(ReleaseForTheLowerBus, WhatIsWithdrawnIsNotSentInTheRunningIntervalEither) {
  release(0b0011, 7, 8);
  edge();
  EXPECT_EQ(slave.release(Channel::one), cansync::ActualRelease::released);
  release(0b0011, 7, 8, 0);
  EXPECT_EQ(slave.release(Channel::one), cansync::ActualRelease::none);
  cansync::ReferenceTelegram asks;
  asks.polled = 0;
  EXPECT_FALSE(slave.receive(asks, std::chrono::microseconds(400)));
  edge();
  EXPECT_EQ(store.unused(Channel::one), 1u);
  EXPECT_EQ(slave.counters(Channel::one).not_released, 1u);
}

}  // namespace
}  // namespace cansyncd
