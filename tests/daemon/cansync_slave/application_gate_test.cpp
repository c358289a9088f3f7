// Which application stands behind the slave, and what of it reaches the realtime thread: over real DDS, with
// the gate's time in the test's hands.
#include "daemon/cansync_slave/gateway/application_gate.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cansync_slave/dds/topics.h"
#include "dds/daemon_identity.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"

namespace cansyncd {
namespace {

using namespace std::chrono_literals;

class ApplicationGateTest : public testing::Test {
 protected:
  static constexpr DaemonIdentity kThisStart = {1, 2, 3};

  ApplicationGateTest() {
    EXPECT_TRUE(eventually(signal_, [this] { return writer_.matched() != 0; }));
  }

  /// Writes a sample and lets the gate take it; its own reader must have it by then.
  void say(cansync_slave_AnswerKind kind, std::vector<std::uint16_t> parameters = {},
           const DaemonIdentity& daemon = kThisStart) {
    cansync_slave_ApplicationAnswer sample = {};
    sample.kind = kind;
    sample.job = 7;
    sample.value = 99;
    sample.parameters._buffer = parameters.data();
    sample.parameters._length = static_cast<std::uint32_t>(parameters.size());
    sample.parameters._maximum = sample.parameters._length;
    gateway::dds::set_daemon(daemon, sample);
    ASSERT_EQ(writer_.write(sample), DDS_RETCODE_OK);
    ASSERT_EQ(dds_wait_for_acks(writer_.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
    (void)gate_.take_samples(now_);
  }
  /// The next order to the realtime thread, if it is of that kind.
  template <class Order>
  std::optional<Order> order() {
    ApplicationOrder next;
    if (!exchange_.orders.try_pop(next) || !std::holds_alternative<Order>(next)) return std::nullopt;
    return std::get<Order>(next);
  }
  bool no_order() {
    ApplicationOrder next;
    return !exchange_.orders.try_pop(next);
  }

  TwoPlaces places_;
  gateway::dds::Participant daemon_{places_.here};
  gateway::dds::Participant program_{places_.there};
  gateway::dds::DataSignal signal_;
  KeptJournal journal_;
  EventPublisher events_{daemon_, journal_, "testbus"};
  SlaveExchange exchange_{64};
  ApplicationGate gate_{daemon_, signal_, events_, kThisStart, 301, exchange_};
  gateway::dds::Writer<cansync_slave_ApplicationAnswer> writer_{program_, 1, &signal_, "tester"};
  SteadyTime now_{1000s};
};

TEST_F(ApplicationGateTest, WhatIsTakenOverAndAnsweredReachesTheRealtimeThreadOnce) {
  say(cansync_slave_ANSWER_PRESENT, {400, 4095});
  const auto taken = order<TakeOver>();
  ASSERT_TRUE(taken);
  EXPECT_TRUE(taken->present);
  EXPECT_FALSE(taken->same_application);
  EXPECT_EQ(taken->taken.numbers.count(), 2u);
  EXPECT_TRUE(taken->taken.numbers[4095]);
  say(cansync_slave_ANSWER_PRESENT, {400, 4095});
  EXPECT_TRUE(no_order()) << "nothing new";
  say(cansync_slave_ANSWER_PRESENT, {400});
  const auto less = order<TakeOver>();
  ASSERT_TRUE(less);
  EXPECT_TRUE(less->same_application) << "what is open stays its";
  say(cansync_slave_ANSWER_PARAMETER);
  const auto answer = order<JobAnswer>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->id, 7u);
  EXPECT_EQ(answer->answer.value, 99u);
  say(cansync_slave_ANSWER_GIVEN_UP);
  const auto gone = order<TakeOver>();
  ASSERT_TRUE(gone);
  EXPECT_FALSE(gone->present);
  EXPECT_EQ(gate_.name(), "");
}

TEST_F(ApplicationGateTest, OneThatSaysNothingForTwoSecondsIsNone) {
  say(cansync_slave_ANSWER_PRESENT, {400});
  ASSERT_TRUE(order<TakeOver>());
  (void)gate_.tick(now_ + 2s);
  EXPECT_TRUE(no_order());
  (void)gate_.tick(now_ + 2s + 1ns);
  const auto gone = order<TakeOver>();
  ASSERT_TRUE(gone);
  EXPECT_FALSE(gone->present);
  say(cansync_slave_ANSWER_PARAMETER);
  EXPECT_TRUE(no_order()) << "it has to say first that it is there again";
  say(cansync_slave_ANSWER_PRESENT, {400});
  const auto back = order<TakeOver>();
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->same_application);
}

TEST_F(ApplicationGateTest, WhatIsWrongReachesNobody) {
  say(cansync_slave_ANSWER_PARAMETER);
  EXPECT_TRUE(no_order()) << "it has taken over nothing";
  say(cansync_slave_ANSWER_PRESENT, {4096});
  EXPECT_TRUE(no_order());
  say(cansync_slave_ANSWER_PRESENT, {400});
  ASSERT_TRUE(order<TakeOver>());
  say(cansync_slave_ANSWER_PARAMETER, {}, {9});
  EXPECT_TRUE(no_order()) << "meant for another start of the daemon";
  gate_.set_read_only(true, now_);
  ASSERT_TRUE(order<TakeOver>());
  say(cansync_slave_ANSWER_PARAMETER);
  EXPECT_TRUE(no_order()) << "read-only";
}

TEST_F(ApplicationGateTest, ADaemonThatBecomesReadOnlyHasNoApplicationAnyMoreAndSaysWhy) {
  say(cansync_slave_ANSWER_PRESENT, {400});
  ASSERT_TRUE(order<TakeOver>());
  gate_.set_read_only(true, now_);
  const auto gone = order<TakeOver>();
  ASSERT_TRUE(gone);
  EXPECT_FALSE(gone->present);
  EXPECT_EQ(gate_.name(), "");
  auto told = journal_.with("EVENT", "application_lost");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("access.read_only"), std::string::npos) << told[0].message;
  say(cansync_slave_ANSWER_PRESENT, {400});
  (void)gate_.tick(now_ + 3s);
  EXPECT_TRUE(no_order());
  EXPECT_EQ(journal_.with("EVENT", "application_lost").size(), 1u);
  gate_.set_read_only(false, now_);
  say(cansync_slave_ANSWER_PRESENT, {400});
  const auto back = order<TakeOver>();
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->present);
}

TEST_F(ApplicationGateTest, TheStatusWordIsNobodysElse) {
  say(cansync_slave_ANSWER_PRESENT, {400, 301});
  EXPECT_TRUE(no_order());
  EXPECT_EQ(gate_.name(), "");
  const auto told = journal_.with("EVENT", "application_refused");
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].message.find("found 301, which is slave.status_parameter"), std::string::npos);
  say(cansync_slave_ANSWER_PRESENT, {400});
  EXPECT_TRUE(order<TakeOver>());
}

TEST_F(ApplicationGateTest, ThatItIsGoneReachesTheRealtimeThreadAlsoWhenThereIsNoRoom) {
  say(cansync_slave_ANSWER_PRESENT, {400});
  ASSERT_TRUE(order<TakeOver>());
  while (exchange_.orders.try_push(JobAnswer{})) {
  }
  say(cansync_slave_ANSWER_GIVEN_UP);
  EXPECT_TRUE(gate_.tick(now_)) << "it has to be called again";
  while (order<JobAnswer>()) {
  }
  EXPECT_TRUE(no_order());
  (void)gate_.tick(now_);
  const auto gone = order<TakeOver>();
  ASSERT_TRUE(gone);
  EXPECT_FALSE(gone->present);
}

TEST_F(ApplicationGateTest, OfTooManyAnswersThatWaitFewerAreTakenAndThoseForThisStart) {
  say(cansync_slave_ANSWER_PRESENT, {400});
  ASSERT_TRUE(order<TakeOver>());
  say(cansync_slave_ANSWER_PARAMETER, {}, {9});
  EXPECT_TRUE(no_order());
  say(cansync_slave_ANSWER_PARAMETER);
  EXPECT_TRUE(order<JobAnswer>()) << "a job of this start";
  while (exchange_.orders.try_push(JobAnswer{})) {
  }
  say(cansync_slave_ANSWER_PARAMETER);
  const auto told = journal_.with("EVENT", "application_refused");
  ASSERT_FALSE(told.empty());
  while (order<JobAnswer>()) {
  }
  say(cansync_slave_ANSWER_PARAMETER);
  const auto taken = order<JobAnswer>();
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->id, 7u);
}

}  // namespace
}  // namespace cansyncd
