// Jobs through gateways: each goes down once, comes back once, with value, format and error, and is busy and
// cancelled on every level. Rows of docs/cansync-cluster.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "cluster_rig.h"

namespace sim::test {
namespace {

using cansync::Outcome;
using cansync::ParameterError;
using cansync::TransferError;

TEST(ClusterJobs, K10TheSubSlaveAddressNamesTheParticipantOnEveryLevel) {
  Levels net(BitRate::mbit1, 8, 4);
  net.start();
  for (const unsigned number : {kMiddle + 0u, kMiddle + 6u, kLowest + 0u, kLowest + 3u}) {
    const auto word = net.end_of(net.read(number, 20));
    EXPECT_EQ(word.outcome, Outcome::done);
    EXPECT_EQ(word.value, LeafSlave::initial(static_cast<std::uint16_t>(number), 20));
    EXPECT_FALSE(word.doubleword);
    const auto doubleword = net.end_of(net.read(number, 21));
    EXPECT_EQ(doubleword.value, LeafSlave::initial(static_cast<std::uint16_t>(number), 21));
    EXPECT_TRUE(doubleword.doubleword);
  }
  // The gateway in the middle is reached by its own number.
  EXPECT_EQ(net.end_of(net.read(kMiddle + kGatewayB, kStatusWord)).value, 0x8007u);
  EXPECT_TRUE(net.ends_a.parameters.empty());
  EXPECT_TRUE(net.ends_b.parameters.empty());
}

TEST(ClusterJobs, K10AWriteIsAppliedOnceWhereItBelongs) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  const auto written = net.end_of(net.write(kLowest + 1, 21, 0xCAFEF00D));
  EXPECT_EQ(written.outcome, Outcome::done);
  using Writes = std::vector<std::pair<std::uint16_t, std::uint32_t>>;
  EXPECT_EQ(net.of(kLowest + 1).applied, (Writes{{21, 0xCAFEF00D}}));
  EXPECT_TRUE(net.of(kLowest + 0).applied.empty());
  EXPECT_TRUE(net.of(kMiddle + 1).applied.empty());
  EXPECT_EQ(net.end_of(net.read(kLowest + 1, 21)).value, 0xCAFEF00Du);
}

TEST(ClusterJobs, K11BlocksOfEveryLengthGoDownAndComeUpThroughTwoLevels) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  std::uint32_t address = 0x1000;
  for (const std::size_t length : {1u, 6u, 7u, 299u, 300u, 301u, 1000u}) {
    address += 0x1000;
    auto sent = bytes_of(length);
    const auto down = net.end_of(net.transfer(kLowest + 1, true, sent, address));
    ASSERT_EQ(down.outcome, Outcome::done) << length;
    std::vector<std::uint8_t> there;
    for (std::size_t start = 0; start < length; start += 300) {
      const auto& block = net.of(kLowest + 1).memory.at(address + static_cast<std::uint32_t>(start));
      there.insert(there.end(), block.begin(), block.end());
    }
    EXPECT_EQ(there, sent) << length;
    std::vector<std::uint8_t> back(length);
    const auto up = net.end_of(net.transfer(kLowest + 1, false, back, address));
    ASSERT_EQ(up.outcome, Outcome::done) << length;
    EXPECT_EQ(back, sent) << length;
  }
  // Each block was written once.
  const auto& blocks = net.of(kLowest + 1).blocks;
  EXPECT_EQ(blocks.size(), 6u + 2u + 4u - 1u);
  EXPECT_TRUE(net.of(kLowest + 0).blocks.empty());
}

TEST(ClusterJobs, K11AnErrorOfTheLastSlaveComesUpAndTheNextBlockMayBegin) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  auto data = bytes_of(40);
  for (const bool download : {true, false}) {
    const auto refused = net.end_of(net.transfer(kLowest + 1, download, data, 0x666));
    EXPECT_EQ(refused.outcome, Outcome::slave_error);
    EXPECT_EQ(refused.error, TransferError::address_not_allowed);
  }
  EXPECT_EQ(net.end_of(net.transfer(kLowest + 1, true, data, 0x2000)).outcome, Outcome::done);
}

TEST(ClusterJobs, K11ACancelAtAnyTimeEndsItBelowToo) {
  for (unsigned after = 0; after < 60; after += 3) {
    for (const bool download : {true, false}) {
      Levels net(BitRate::mbit1, 8, 1);
      net.start();
      net.of(kLowest).busy = [] { return 4u; };
      auto data = bytes_of(60);
      const auto request = net.transfer(kLowest, download, data, 0x2000);
      ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
      net.run(after);
      static_cast<void>(net.upper_master().cancel(request.id));
      ASSERT_TRUE(net.run_until([&] { return net.ends.transfers.contains(request.id); }));
      ASSERT_TRUE(net.run_until([&] {
        return net.cluster().gateway().running() == 0 && net.gateway_b->cluster().gateway().running() == 0;
      })) << after;
      EXPECT_LE(net.of(kLowest).blocks.size(), 1u);
      auto again = bytes_of(20);
      EXPECT_EQ(net.end_of(net.transfer(kLowest, true, again, 0x3000)).outcome, Outcome::done) << after;
    }
  }
}

TEST(ClusterJobs, K11AJobForTheGatewayItselfEndsTheOneBelow) {
  Levels net(BitRate::mbit1, 3);
  net.start();
  net.of(kMiddle).busy = [] { return 500u; };
  auto data = bytes_of(30);
  const auto request = net.transfer(kMiddle, true, data, 0x2000);
  ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
  net.run(60);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  static_cast<void>(net.upper_master().cancel(request.id));
  // Nobody serves the gateway's own blocks here: refused at once, whatever still ends below.
  EXPECT_EQ(net.end_of(net.transfer(0, true, data, 0x2000)).error, TransferError::not_possible);
  EXPECT_TRUE(net.run_until([&] { return net.cluster().gateway().running() == 0; }));
  EXPECT_TRUE(net.of(kMiddle).blocks.empty());
}

TEST(ClusterJobs, K11ABlockThatTakesTooLongBelowIsAnErrorAboveBeforeItsAskerGivesUp) {
  Levels net;
  net.start();
  auto data = bytes_of(30);
  for (const bool download : {true, false}) {
    net.of(kMiddle).busy = [] { return 1'000'000u; };
    const auto request = net.transfer(kMiddle, download, data, 0x2000);
    ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
    ASSERT_TRUE(net.run_until([&] { return net.ends.transfers.contains(request.id); }, 100'000));
    EXPECT_EQ(net.ends.transfers[request.id].outcome, Outcome::slave_error) << "no timeout";
    EXPECT_EQ(net.ends.transfers[request.id].error, TransferError::cancelled_by_slave);
    EXPECT_TRUE(net.run_until([&] { return net.cluster().gateway().running() == 0; }));
    net.of(kMiddle).busy = [] { return 0u; };
    EXPECT_EQ(net.end_of(net.transfer(kMiddle, true, data, 0x3000)).outcome, Outcome::done);
  }
}

TEST(ClusterJobs, K12TheMasterGivesTheAddressWithEveryJob) {
  Levels net;
  net.start();
  // Two participants below in turn; each job carries its own address.
  std::vector<cansync::ParameterRequest> requests;
  for (unsigned i = 0; i < 20; ++i) requests.push_back(net.read(kMiddle + i % 3, 30 + i));
  for (const auto& request : requests) ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
  ASSERT_TRUE(net.run_until([&] { return net.ends.parameters.size() == requests.size(); }));
  for (const auto& request : requests) {
    EXPECT_EQ(net.ends.parameters[request.id].value,
              LeafSlave::initial(request.sub_slave.value, request.number.value()));
  }
}

TEST(ClusterJobs, K13ItIsBusyAboveUntilItIsDoneBelow) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  for (const unsigned busy : {0u, 1u, 5u, 40u}) {
    net.of(kLowest + 1).busy = [busy] { return busy; };
    const auto result = net.end_of(net.write(kLowest + 1, 20, busy));
    EXPECT_EQ(result.outcome, Outcome::done) << busy;
    EXPECT_GT(result.busy_replies, busy) << busy;
    EXPECT_EQ(net.of(kLowest + 1).applied.back().second, busy);
  }
  EXPECT_EQ(net.of(kLowest + 1).applied.size(), 4u);
}

TEST(ClusterJobs, K13ErrorsAndFormatsComeUpUnchanged) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  const auto absent = net.end_of(net.read(kLowest + 1, 999));
  EXPECT_EQ(absent.outcome, Outcome::slave_error);
  EXPECT_EQ(absent.error, ParameterError::not_present);
  auto wrong = net.write(kLowest + 1, 21, 5);
  wrong.format = cansync::ParameterFormat::word;
  const auto refused = net.end_of(wrong);
  EXPECT_EQ(refused.outcome, Outcome::slave_error);
  EXPECT_EQ(refused.error, ParameterError::wrong_format);
  auto as_it_says = net.write(kLowest + 1, 21, 5);
  as_it_says.format = cansync::ParameterFormat::as_slave_says;
  EXPECT_EQ(net.end_of(as_it_says).outcome, Outcome::done);
  EXPECT_EQ(net.of(kLowest + 1).applied.size(), 1u);
}

TEST(ClusterJobs, K13ASlaveThatIsGoneBelowIsAnErrorAboveAndNotASilence) {
  Levels net;
  net.start();
  net.middle[1]->deaf = true;
  const auto first = net.end_of(net.write(kMiddle + 1, 20, 5));
  EXPECT_EQ(first.outcome, Outcome::slave_error);
  EXPECT_EQ(first.error, ParameterError::unspecified) << "nobody knows whether it was written";
  ASSERT_TRUE(
      net.run_until([&] { return !net.cluster().lower().slave(*SlaveNumber::from(1)).responds; }, 5000));
  const auto second = net.end_of(net.write(kMiddle + 1, 20, 6));
  EXPECT_EQ(second.error, ParameterError::not_available_now);
  // A block says as well that the slave is away, and not that the table is wrong.
  auto data = bytes_of(20);
  for (const bool download : {true, false})
    EXPECT_EQ(net.end_of(net.transfer(kMiddle + 1, download, data)).error, TransferError::cancelled_by_slave);
  EXPECT_EQ(net.end_of(net.transfer(999, true, data)).error, TransferError::not_possible)
      << "not in the table";
  // The lower bus is gone, and comes back.
  for (LeafSlave* slave : net.middle) slave->deaf = true;
  net.cluster().lower().bus_lost();
  EXPECT_EQ(net.end_of(net.read(kMiddle + 0, 20)).error, ParameterError::not_available_now);
  for (LeafSlave* slave : net.middle) slave->deaf = false;
  EXPECT_TRUE(net.run_until([&] { return net.cluster().lower().slave(SlaveNumber{}).responds; }));
  EXPECT_EQ(net.end_of(net.read(kMiddle + 0, 20)).outcome, Outcome::done);
}

TEST(ClusterJobs, K13AnotherJobAboveCancelsTheOneBelow) {
  Levels net(BitRate::mbit1, 8, 2);
  net.start();
  net.of(kLowest + 1).busy = [] { return 100'000u; };
  const auto hanging = net.write(kLowest + 1, 20, 7);
  ASSERT_EQ(net.upper_master().submit(hanging), cansync::Refusal::none);
  net.run(50);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  EXPECT_EQ(net.gateway_b->cluster().gateway().running(), 1u);
  ASSERT_EQ(net.upper_master().cancel(hanging.id), cansync::Refusal::none);
  EXPECT_EQ(net.end_of(net.read(kLowest + 0, 20)).value, LeafSlave::initial(kLowest, 20));
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  EXPECT_EQ(net.gateway_b->cluster().gateway().running(), 0u);
  EXPECT_TRUE(net.of(kLowest + 1).applied.empty());
}

TEST(ClusterJobs, K13AQuestionForTheGatewayItselfDropsTheJobBelow) {
  Levels net;
  net.start();
  net.of(kMiddle + 1).busy = [] { return 100'000u; };
  const auto hanging = net.write(kMiddle + 1, 20, 7);
  ASSERT_EQ(net.upper_master().submit(hanging), cansync::Refusal::none);
  net.run(50);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  ASSERT_EQ(net.upper_master().cancel(hanging.id), cansync::Refusal::none);
  EXPECT_EQ(net.end_of(net.read(0, kStatusWord)).value, 0x8007u);
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  // So does the end of synchronous operation above.
  ASSERT_EQ(net.upper_master().submit(net.write(kMiddle + 1, 20, 8)), cansync::Refusal::none);
  net.run(50);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  net.cluster().upper().control(cansync::ControlCommand::cold_restart);
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  EXPECT_TRUE(net.of(kMiddle + 1).applied.empty());
}

TEST(ClusterJobs, K13AJobThatIsDroppedTakesNoControlWordOfTheFailsafeReactionWithIt) {
  Levels net;
  net.start();
  net.of(kMiddle).busy = [] { return 100'000u; };
  ASSERT_EQ(net.upper_master().submit(net.write(kMiddle, 20, 7)), cansync::Refusal::none);
  net.run(50);
  ASSERT_EQ(net.cluster().gateway().running(), 1u);
  for (unsigned n = 0; n < 3; ++n) {
    cansync::ControlWordRequest word;
    word.id = cansync::kFailsafeJobs + n;
    word.slave = *SlaveNumber::from(n);
    word.control_word = 0x0104;
    word.failsafe = true;
    ASSERT_EQ(net.cluster().lower().submit(word), cansync::Refusal::none);
  }
  static_cast<cansync::SlaveApplication&>(net.cluster().gateway()).parameter_dropped();
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  net.run(10);
  for (unsigned n = 0; n < 3; ++n)
    EXPECT_EQ(net.of(kMiddle + n).control_words, (std::vector<std::uint16_t>{0x0104})) << n;
}

TEST(ClusterJobs, K11ABlockNobodyGoesOnWithIsCancelledBelow) {
  Levels net;
  net.a.holdover = std::chrono::seconds(100);
  net.a.cluster.gateway.transfer_gone = net.times.interval * 200;
  net.start();
  net.of(kMiddle + 1).busy = [] { return 100'000u; };
  auto data = bytes_of(60);
  ASSERT_EQ(net.upper_master().submit(net.transfer(kMiddle + 1, false, data)), cansync::Refusal::none);
  net.run(50);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  Fault fault;
  fault.kind = FaultKind::silent;
  fault.node = NodeNumber{kGatewayA};
  fault.from = net.top_bus->intervals() + 1;
  fault.to = fault.from + 400;
  net.top_bus->faults().add(fault);
  net.run(150);
  EXPECT_EQ(net.cluster().gateway().running(), 1u);
  net.of(kMiddle + 1).busy = [] { return 0u; };
  net.run(100);
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  EXPECT_TRUE(net.run_until([&] { return net.all_active(); }, 2000));
  net.run(1500);
  EXPECT_EQ(net.end_of(net.transfer(kMiddle + 1, true, data, 0x4000)).outcome, Outcome::done);
}

TEST(ClusterJobs, K13AJobNobodyAsksAboutIsDroppedOnEveryLevel) {
  Levels net(BitRate::mbit1, 8, 2);
  for (auto* gateway : {&net.a, &net.b}) {
    gateway->cluster.gateway.monitoring = net.times.interval * 100'000;
    gateway->cluster.gateway.asker_gone = net.times.interval * 200;
  }
  net.start();
  net.of(kLowest + 1).busy = [] { return 100'000u; };
  const auto hanging = net.read(kLowest + 1, 20);
  ASSERT_EQ(net.upper_master().submit(hanging), cansync::Refusal::none);
  net.run(300);
  EXPECT_EQ(net.cluster().gateway().running(), 1u) << "asked about, it stays";
  ASSERT_EQ(net.upper_master().cancel(hanging.id), cansync::Refusal::none);
  net.run(210);
  EXPECT_EQ(net.cluster().gateway().running(), 0u);
  net.run(210);
  EXPECT_EQ(net.gateway_b->cluster().gateway().running(), 0u);
}

TEST(ClusterJobs, K13AValueThatNobodyFetchedIsNotGivenLater) {
  Levels net;
  net.a.cluster.gateway.asker_gone = std::chrono::milliseconds(2100);
  net.start();
  net.of(kMiddle + 1).busy = [] { return 10u; };
  const auto first = net.read(kMiddle + 1, 20);
  ASSERT_EQ(net.upper_master().submit(first), cansync::Refusal::none);
  net.run(5);
  ASSERT_EQ(net.upper_master().cancel(first.id), cansync::Refusal::none);
  net.run(2200);  // its value has come up, and nobody asked
  auto change = net.write(0, 20, 4321);
  change.slave = *SlaveNumber::from(1);
  change.sub_slave = {};
  ASSERT_EQ(net.cluster().lower().submit(change), cansync::Refusal::none);
  net.run(50);
  EXPECT_EQ(net.end_of(net.read(kMiddle + 1, 20)).value, 4321u);
}

/// The gateway is too slow for the slot of its answer now and then: the master repeats its question.
TEST(ClusterJobs, K13AnAnswerThatWasNotOnTheBusDoesNotWriteAgain) {
  Levels net(BitRate::mbit1, 8, 2);
  net.master.master.startup.lost_after = 30;
  net.a.cluster.lower.startup.lost_after = 30;
  net.start();
  std::mt19937_64 dice(5);
  for (ClusterNode* gateway : {net.gateway_a, net.gateway_b})
    gateway->slow = [&] { return dice() % 5 == 0 ? net.times.interval : can::Time{}; };
  unsigned done = 0;
  for (std::uint32_t value = 1; value <= 60; ++value) {
    const auto result = net.end_of(net.write(kLowest + 1, 20, value));
    if (result.outcome == Outcome::done) ++done;
  }
  EXPECT_GT(done, 20u);
  auto applied = net.of(kLowest + 1).applied;
  EXPECT_GE(applied.size(), done);
  std::ranges::sort(applied);
  EXPECT_EQ(std::ranges::adjacent_find(applied), applied.end()) << "a value was written twice";
  EXPECT_GT(net.cluster().gateway().counters().repeated, 0u) << "what comes from memory is counted";
}

/// Parameters that are orders: a step, a reset.
TEST(ClusterJobs, K13TheSameWriteAfterItsAnswerWasOnTheBusIsAnotherWrite) {
  Levels net;
  net.master.master.startup.status_period = {};
  net.start();
  for (unsigned times = 1; times <= 5; ++times) {
    ASSERT_EQ(net.end_of(net.write(kMiddle + 1, 20, 5)).outcome, Outcome::done);
    EXPECT_EQ(net.of(kMiddle + 1).applied.size(), times);
  }
  EXPECT_EQ(net.cluster().gateway().counters().repeated, 0u);
}

/// A write to a slave below whose busy answer the master gets, and the answer not: it ends without one.
void write_without_answer(Levels& net, std::uint32_t value) {
  LeafSlave& leaf = net.of(kMiddle + 1);
  const std::size_t before = leaf.applied.size();
  leaf.busy = [] { return 10u; };
  auto request = net.write(kMiddle + 1, 20, value);
  request.monitoring_time = net.times.interval * 60;
  ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
  ASSERT_TRUE(net.run_until([&] { return net.cluster().gateway().running() != 0; }));
  net.run(4);
  net.gateway_a->slow = [&net] { return net.times.interval; };
  ASSERT_TRUE(net.run_until([&] { return net.ends.parameters.contains(request.id); }));
  net.gateway_a->slow = {};
  leaf.busy = [] { return 0u; };
  EXPECT_NE(net.ends.parameters[request.id].outcome, Outcome::done);
  ASSERT_EQ(leaf.applied.size(), before + 1);
}

TEST(ClusterJobs, K13TheSameWriteLaterIsAnotherWrite) {
  Levels net;
  net.a.cluster.gateway.asker_gone = net.times.interval * 300;
  net.master.master.startup.status_period = {};
  net.master.master.startup.lost_after = 250;
  net.start();
  const auto written = [&](unsigned times) {
    ASSERT_EQ(net.end_of(net.write(kMiddle + 1, 20, 5)).outcome, Outcome::done);
    EXPECT_EQ(net.of(kMiddle + 1).applied.size(), times);
  };
  write_without_answer(net, 5);
  net.run(200);
  written(1);
  write_without_answer(net, 5);
  net.run(310);
  written(3);
  // Another question in between shows as well that the answer has come, whomever it is for.
  write_without_answer(net, 5);
  static_cast<void>(net.end_of(net.read(kMiddle + 1, 20)));
  written(5);
  write_without_answer(net, 5);
  static_cast<void>(net.end_of(net.read(0, kStatusWord)));
  written(7);
}

/// 111 is written, and its answer never comes on the bus; another client of the lower bus writes 222.
TEST(ClusterJobs, K13AnAnswerThatWasNeverOnTheBusIsNotRememberedForEver) {
  Levels net;
  net.a.cluster.gateway.asker_gone = net.times.interval * 300;
  net.master.master.startup.status_period = {};
  net.master.master.startup.lost_after = 250;
  net.start();
  LeafSlave& leaf = net.of(kMiddle + 1);
  write_without_answer(net, 111);
  auto below = net.write(0, 20, 222);
  below.slave = *SlaveNumber::from(1);
  below.sub_slave = {};
  ASSERT_EQ(net.cluster().lower().submit(below), cansync::Refusal::none);
  net.run(20);
  ASSERT_EQ(leaf.applied.back().second, 222u);
  EXPECT_EQ(net.end_of(net.write(kMiddle + 1, 20, 111)).error, ParameterError::unspecified)
      << "neither \"done\", which is untrue, nor a second write";
  net.run(2000);
  EXPECT_EQ(net.end_of(net.write(kMiddle + 1, 20, 111)).outcome, Outcome::done);
  EXPECT_EQ(leaf.applied.back().second, 111u) << "\"done\" means that the drive has it";
}

/// An error whose answer was not on the bus is asked below again.
TEST(ClusterJobs, K13ARefusalThatWasNeverOnTheBusIsNotRepeatedForEver) {
  Levels net;
  net.master.master.startup.status_period = {};
  net.master.master.startup.lost_after = 250;
  net.start();
  LeafSlave& leaf = net.of(kMiddle + 1);
  leaf.refusals = 1;
  leaf.refusal = ParameterError::not_available_now;
  leaf.busy = [] { return 10u; };
  const auto request = net.write(kMiddle + 1, 20, 5);
  ASSERT_EQ(net.upper_master().submit(request), cansync::Refusal::none);
  ASSERT_TRUE(net.run_until([&] { return net.cluster().gateway().running() != 0; }));
  net.run(4);
  net.gateway_a->slow = [&net] { return net.times.interval; };
  ASSERT_TRUE(net.run_until([&] { return leaf.refusals == 0; }));
  net.run(3);
  net.gateway_a->slow = {};
  ASSERT_TRUE(net.run_until([&] { return net.ends.parameters.contains(request.id); }));
  EXPECT_EQ(net.ends.parameters[request.id].outcome, Outcome::done);
  EXPECT_EQ(leaf.applied.size(), 1u);
}

TEST(ClusterJobs, K13AWriteThatWaitedTooLongBehindOthersIsNotSentAnyMore) {
  Levels net;
  net.start();
  LeafSlave& leaf = net.of(kMiddle + 1);
  leaf.busy = [] { return 100'000u; };
  auto before = net.read(0, 21);
  before.slave = *SlaveNumber::from(1);
  before.sub_slave = {};
  before.monitoring_time = std::chrono::milliseconds(3500);
  ASSERT_EQ(net.cluster().lower().submit(before), cansync::Refusal::none);
  net.run(10);
  const auto result = net.end_of(net.write(kMiddle + 1, 20, 5));
  EXPECT_EQ(result.outcome, Outcome::slave_error);
  EXPECT_EQ(result.error, ParameterError::not_available_now) << "nothing was written";
  leaf.busy = [] { return 0u; };
  ASSERT_TRUE(net.run_until([&] { return net.ends_a.parameters.contains(before.id); }));
  net.run(100);
  EXPECT_TRUE(leaf.applied.empty());
}

TEST(ClusterJobs, K13TheSameWriteIsNeitherDoneNorGivenAgainWhenTheValueBelowMayBeAnother) {
  Levels net;
  net.master.master.startup.status_period = {};
  net.master.master.startup.lost_after = 250;
  net.a.cluster.lower.startup.status_period = net.times.interval * 50;
  net.start();
  LeafSlave& leaf = net.of(kMiddle + 1);
  const auto below = [&](unsigned slave, bool write) {
    auto request = write ? net.write(0, 20, 7) : net.read(0, 20);
    request.slave = *SlaveNumber::from(slave);
    request.sub_slave = {};
    ASSERT_EQ(net.cluster().lower().submit(request), cansync::Refusal::none);
    net.run(20);
  };
  const auto written = [&](ParameterError error, unsigned times) {
    EXPECT_EQ(net.end_of(net.write(kMiddle + 1, 20, 5)).error, error);
    EXPECT_EQ(leaf.applied.size(), times);
  };
  const auto ask_else = [&] { static_cast<void>(net.end_of(net.read(0, kStatusWord))); };
  write_without_answer(net, 5);
  below(1, true);
  ASSERT_EQ(leaf.applied.size(), 2u);
  written(ParameterError::unspecified, 2);
  ask_else();
  written(ParameterError::none, 3);
  // Reads and other slaves change nothing.
  write_without_answer(net, 5);
  below(1, false);
  below(0, true);
  written(ParameterError::none, 4);
  write_without_answer(net, 5);
  const auto responds = [&] { return net.cluster().lower().slave(*SlaveNumber::from(1)).responds; };
  leaf.deaf = true;
  ASSERT_TRUE(net.run_until([&] { return !responds(); }, 1000));
  leaf.deaf = false;
  ASSERT_TRUE(net.run_until(responds, 1000));
  written(ParameterError::unspecified, 5);
  ask_else();
  written(ParameterError::none, 6);
}

/// The gateway below answers 0xFFFF: its slave may have the value. The answer of the gateway above is not on the
/// bus.
TEST(ClusterJobs, K13AWriteOfWhichALevelBelowDoesNotKnowIsNotGivenBelowAgain) {
  Levels net(BitRate::mbit1, 8, 2);
  net.master.master.startup.status_period = {};
  net.master.master.startup.lost_after = 250;
  net.start();
  LeafSlave& leaf = net.of(kLowest + 1);
  leaf.busy = [&net] {
    Fault answer;
    answer.kind = FaultKind::lost;
    answer.identifier = cansync::identifier::response + 1;
    answer.count = 1;
    net.lowest_bus->faults().add(answer);
    return 0u;
  };
  unsigned slow = 0;
  net.gateway_a->slow = [&] {
    const bool answer = !leaf.applied.empty() && net.cluster().gateway().running() == 0;
    return answer && slow++ == 0 ? net.times.interval : can::Time{};
  };
  const auto result = net.end_of(net.write(kLowest + 1, 20, 5));
  EXPECT_GT(slow, 1u) << "it was asked for again";
  EXPECT_EQ(result.outcome, Outcome::taken) << "whether it was done is not known";
  EXPECT_EQ(leaf.applied.size(), 1u);
}

TEST(ClusterJobs, K13AWriteThatWasRefusedMayBeGivenAgainAtOnce) {
  for (const auto error : {ParameterError::not_available_now, ParameterError::unspecified}) {
    Levels net;
    net.master.master.startup.status_period = {};
    net.start();
    net.of(kMiddle + 1).refusals = 1;
    net.of(kMiddle + 1).refusal = error;
    EXPECT_EQ(net.end_of(net.write(kMiddle + 1, 20, 5)).error, error);
    EXPECT_EQ(net.end_of(net.write(kMiddle + 1, 20, 5)).outcome, Outcome::done);
    EXPECT_EQ(net.of(kMiddle + 1).applied.size(), 1u);
  }
}

}  // namespace
}  // namespace sim::test
