// Whose actual values reach the realtime thread, and that they are withdrawn with their writer and their right:
// over real DDS, with the gate's time in the test's hands.
#include "daemon/cansync_slave/gateway/release_gate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

#include "cansync_slave/dds/topics.h"
#include "dds/daemon_identity.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"

namespace cansyncd {
namespace {

using namespace std::chrono_literals;

class ReleaseGateTest : public testing::Test {
 protected:
  static constexpr DaemonIdentity kThisStart = {1, 2, 3};

  ReleaseGateTest() {
    EXPECT_TRUE(eventually(signal_, [this] { return writer_.matched() != 0; }));
  }

  /// Writes a sample of telegram 1, and lets the gate take it.
  void write(bool given_up = false) {
    cansync_slave_ActualRelease sample = {};
    sample.telegram = 1;
    sample.valid = 0x03;
    sample.wait_intervals = 1000;
    sample.given_up = given_up;
    gateway::dds::set_daemon(kThisStart, sample);
    ASSERT_EQ(dds_write_ts(writer_.handle(), &sample, kWritten), DDS_RETCODE_OK);
    ASSERT_EQ(dds_wait_for_acks(writer_.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
    (void)gate_.take_samples(now_, kWritten + age_.count());
  }
  /// For how many intervals each order to the realtime thread releases; 0: it withdraws.
  std::vector<std::uint32_t> orders() {
    std::vector<std::uint32_t> found;
    ReleaseOrder order;
    while (exchange_.releases.try_pop(order)) found.push_back(order.intervals);
    return found;
  }

  using Intervals = std::vector<std::uint32_t>;

  static constexpr dds_time_t kWritten = DDS_SECS(1'700'000'000);
  std::chrono::nanoseconds age_ = 1ms;  ///< of a sample when the gate takes it

  TwoPlaces places_;
  gateway::dds::Participant daemon_{places_.here};
  gateway::dds::Participant program_{places_.there};
  gateway::dds::DataSignal signal_;
  KeptJournal journal_;
  EventPublisher events_{daemon_, journal_, "testbus"};
  SlaveExchange exchange_{64};
  ReleaseGate gate_{daemon_, signal_, events_, kThisStart, exchange_};
  gateway::dds::Writer<cansync_slave_ActualRelease> writer_{program_, 1, &signal_, "tester"};
  SteadyTime now_{1000s};
};

TEST_F(ReleaseGateTest, WhatWasReleasedIsWithdrawnWithTheRightToDoSo) {
  write();
  EXPECT_EQ(orders(), Intervals{1000});
  gate_.set_read_only(true, now_);
  EXPECT_EQ(orders(), Intervals{0});
  const auto told = journal_.with("EVENT", "actual_writer_lost");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("access.read_only"), std::string::npos) << told[0].message;
  write();
  EXPECT_EQ(orders(), Intervals{});
  gate_.set_read_only(false, now_);
  write();
  EXPECT_EQ(orders(), Intervals{1000});
}

TEST_F(ReleaseGateTest, AWithdrawalIsTriedAgainUntilThereIsRoom) {
  write();
  while (exchange_.releases.try_push(ReleaseOrder{.intervals = 7})) {
  }
  write(true);
  EXPECT_TRUE(gate_.tick(now_)) << "it has to be called again";
  (void)orders();
  EXPECT_FALSE(gate_.tick(now_));
  EXPECT_EQ(orders(), Intervals{0});
  EXPECT_FALSE(gate_.tick(now_)) << "once";
  EXPECT_EQ(orders(), Intervals{});
}

TEST_F(ReleaseGateTest, NoReleaseOvertakesAWithdrawal) {
  write();
  while (exchange_.releases.try_push(ReleaseOrder{.intervals = 7})) {
  }
  gate_.set_read_only(true, now_);
  gate_.set_read_only(false, now_);
  (void)orders();
  write();
  EXPECT_EQ(orders(), (Intervals{0, 1000}));
}

TEST_F(ReleaseGateTest, OfTooManyThatWaitFewerAreTaken) {
  write();
  while (exchange_.releases.try_push(ReleaseOrder{.intervals = 7})) {
  }
  write();
  const auto told = journal_.with("EVENT", "actual_refused");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("give fewer"), std::string::npos) << told[0].message;
  (void)orders();
  write();
  EXPECT_EQ(orders(), Intervals{1000});
}

TEST_F(ReleaseGateTest, WhatIsTooOldOrFromTheFutureIsNotTaken) {
  for (const auto age : {500ms, -500ms}) {
    age_ = age;
    write();
    EXPECT_EQ(orders(), Intervals{1000});
  }
  for (const auto age : {501ms, -501ms}) {
    age_ = age;
    write();
    EXPECT_EQ(orders(), Intervals{});
  }
  const auto told = journal_.with("EVENT", "actual_refused");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("written 501 ms ago; allowed: 500 ms"), std::string::npos)
      << told[0].message;
}

TEST_F(ReleaseGateTest, AProgramThatGaveItsTelegramUpReleasesItAgainWhenItIsStartedAgain) {
  write();
  write(true);
  EXPECT_EQ(journal_.with("EVENT", "actual_writer_lost").size(), 1u);
  EXPECT_EQ(orders(), (Intervals{1000, 0}));
  write();
  EXPECT_EQ(orders(), Intervals{1000});
}

}  // namespace
}  // namespace cansyncd
