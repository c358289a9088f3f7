// A real master against the slave's core with supervision and service, on a simulated line at all four bit
// rates. Every telegram is judged by the manual's slots (slot_judge.h).
#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "slave_line_rig.h"

namespace sim::test {
namespace {

using cansync::ParameterError;
using cansync::SlaveFault;
using cansync::SlaveReaction;
using cansync::TransferError;

INSTANTIATE_TEST_SUITE_P(AllBitRates, SlaveAcceptance,
                         ::testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                           BitRate::mbit1),
                         [](const auto& instance) {
                           return std::to_string(cansync::slot_times(instance.param).bits_per_second);
                         });

Fault lost_references(SlaveLine& line, std::uint64_t intervals) {
  Fault fault = fault_soon(line, FaultKind::lost, 2, intervals);
  fault.identifier = cansync::identifier::reference_one;
  fault.mask = cansync::identifier::channel_bits;
  return fault;
}

// --- start-up and process data
TEST_P(SlaveAcceptance, S6StartUpActivationLockReferencesInActualValuesOut) {
  SlaveLine line(GetParam());
  line.build();
  line.run(3);
  EXPECT_EQ(line.master().state(), cansync::State::setting_up_master);
  EXPECT_TRUE(line.slave().slave.sync_activated());
  EXPECT_FALSE(line.slave().supervision.synchronized());
  EXPECT_EQ(line.judge.count[0x100], 0u) << "no reference values before everybody is synchronized";
  ASSERT_TRUE(line.run_until([&] { return line.slave().supervision.synchronized(); }));
  ASSERT_TRUE(line.run_until([&] { return is_active(line.master().state()); }));
  line.run(2);
  const unsigned asked = line.judge.count[0x100];
  const unsigned answered = line.judge.count[0x300];
  line.run(1000);
  EXPECT_EQ(line.judge.count[0x100] - asked, 1000u);
  EXPECT_EQ(line.judge.count[0x300] - answered, 1000u);
  EXPECT_EQ(line.judge.count[0x380], line.judge.count[0x180]);
  EXPECT_EQ(line.slave().slave.references()[0],
            value_of(line.master_settings.references[0], line.master_node().interval() - 1));
  EXPECT_EQ(line.slave().slave.references()[4], 77u);
  EXPECT_EQ(line.ends.newest.value[0], 0x1000u);
  EXPECT_EQ(line.ends.newest.value[5], 0x4000u);
  EXPECT_EQ(line.one().sent, line.one().asked);
  EXPECT_EQ(line.one().late + line.one().lost + line.one().not_released, 0u);
  EXPECT_EQ(line.slave().supervision.missed_references(), 0u);
  EXPECT_EQ(line.slave().slave.response_counters().late, 0u);
}

TEST_P(SlaveAcceptance, S16NoActualValueStartsAfterItsSlotHoweverSlowTheSlaveIs) {
  unsigned sent = 0;
  unsigned late = 0;
  for (int bits = 0; bits <= 200; bits += 2) {
    SlaveLine line(GetParam());
    line.under_test.delay = line.times.bit_time() * bits;
    line.master_settings.master.startup.enable = cansync::EnableRule::any;
    line.build();
    line.run(40);
    EXPECT_EQ(line.one().sent, line.judge.count[0x300]);
    EXPECT_EQ(line.two().sent, line.judge.count[0x380]);
    EXPECT_EQ(line.one().asked, line.one().sent + line.one().late);
    sent += line.judge.count[0x300];
    late += static_cast<unsigned>(line.one().late);
  }
  EXPECT_GT(sent, 500u);
  EXPECT_GT(late, 500u);
}

TEST_P(SlaveAcceptance, S16LateByOneMicrosecondIsLeftOut) {
  // The length of WRC1 is known from a line before; all of its values stand still.
  const auto run = [](can::Time delay, can::Time& end) {
    SlaveLine line(GetParam());
    line.master_settings.references[0] = {ReferenceCurve::Kind::constant, 0x5555};
    line.under_test.delay = delay;
    line.master_settings.master.startup.enable = cansync::EnableRule::any;
    line.build();
    line.run(30);
    can::ReceivedFrame received;
    const can::Time until = line.line().now() + 2 * line.times.interval;
    while (line.line().now() < until) {
      line.line().wait_until(until);
      while (line.line().receive(received)) {
        if (cansync::identifier::channel_of(received.frame.id) == 0x100)
          end = received.end - line.master_node().edge();
      }
    }
    return std::pair(line.one().sent, line.one().late);
  };
  can::Time end{};
  ASSERT_GT(run({}, end).first, 20u);
  ASSERT_GT(end.count(), 0);
  can::Time other{};
  const can::Time latest = slot_times(GetParam()).actual_one;
  const auto in_time = run(latest - end, other);
  EXPECT_GT(in_time.first, 20u);
  EXPECT_EQ(in_time.second, 0u);
  const auto too_late = run(latest - end + std::chrono::microseconds(1), other);
  EXPECT_EQ(too_late.first, 0u);
  EXPECT_GT(too_late.second, 20u);
}

TEST_P(SlaveAcceptance, S16AskedAndNotReleasedReleasedAndNotAsked) {
  SlaveLine line(GetParam());
  line.start();
  line.slave().release = false;
  line.run(2);
  const unsigned before = line.judge.count[0x300];
  line.run(100);
  EXPECT_EQ(line.judge.count[0x300], before) << "asked and not released: none";
  line.slave().release = true;
  line.master().set_polling(Channel::one, {cansync::Cursor::Kind::nobody, {}});
  line.run(2);
  const unsigned after = line.judge.count[0x300];
  const std::uint64_t not_asked = line.one().not_asked;
  line.run(100);
  EXPECT_EQ(line.judge.count[0x300], after) << "released and not asked: none";
  EXPECT_EQ(line.one().not_asked - not_asked, 100u);
}

TEST_P(SlaveAcceptance, S16AskedTwiceInAnIntervalItAnswersOnce) {
  SlaveLine line(GetParam());
  line.start();
  Fault twice = fault_soon(line, FaultKind::inject, 2, 50);
  twice.frame.id = cansync::identifier::reference_one + 5;
  twice.frame.dlc = 0;
  // Where nothing else is under way: after the response, before WRC1.
  twice.delay = line.times.response + line.times.bit_time() * 5;
  line.line().faults().add(twice);
  const std::uint64_t sent = line.one().sent;
  const std::uint64_t asked = line.one().asked;
  const std::uint64_t refused = line.one().not_released;
  line.run(60);
  EXPECT_EQ(line.one().asked - asked, 110u);
  EXPECT_EQ(line.one().sent - sent, 60u);
  EXPECT_EQ(line.one().not_released - refused, 50u);
}

// --- supervision

TEST_P(SlaveAcceptance, S12ReferencesMissingOnceUpToTheLimitAndAtTheLimit) {
  constexpr unsigned kLimit = 6;
  SlaveLine line(GetParam());
  line.under_test.supervision.misses_until_fault = kLimit;
  line.under_test.supervision.on_references_missing = SlaveReaction::pulse_inhibit;
  line.start();
  for (const unsigned away : {1u, kLimit - 1}) {
    line.line().faults().add(lost_references(line, away));
    line.slave().most_misses = 0;
    line.slave().extrapolated = false;
    line.run(20);
    EXPECT_EQ(line.slave().most_misses, away);
    EXPECT_TRUE(line.slave().extrapolated);
    EXPECT_TRUE(line.slave().faults.empty());
    EXPECT_FALSE(line.slave().supervision.extrapolating()) << "they came again";
  }
  line.line().faults().add(lost_references(line, kLimit));
  line.run(20);
  EXPECT_EQ(line.slave().faults, std::vector{SlaveFault::references_missing});
  EXPECT_EQ(line.slave().supervision.reaction(), SlaveReaction::pulse_inhibit);
  EXPECT_TRUE(line.slave().supervision.synchronized()) << "the edges were there";
}

TEST_P(SlaveAcceptance, S11EdgesMissingOnceAndForTooLongAndTheirReturn) {
  constexpr unsigned kLimit = 5;
  SlaveLine line(GetParam());
  line.under_test.supervision.edges_until_fault = kLimit;
  line.start();
  const auto lose = [&](unsigned edges) {
    Fault fault = fault_soon(line, FaultKind::missing_sync, 2, edges);
    fault.node = NodeNumber{5};
    line.line().faults().add(fault);
    line.run(kLimit + 5);
  };
  lose(1);
  EXPECT_EQ(line.slave().supervision.missed_edges(), 1u);
  EXPECT_TRUE(line.slave().supervision.synchronized());
  lose(kLimit - 1);
  EXPECT_TRUE(line.slave().supervision.synchronized());
  EXPECT_TRUE(line.slave().faults.empty());
  lose(kLimit);
  EXPECT_FALSE(line.slave().supervision.synchronized());
  EXPECT_EQ(line.slave().faults.front(), SlaveFault::sync_lost);
  EXPECT_EQ(line.slave().supervision.reaction(), SlaveReaction::quick_stop);
  EXPECT_EQ(line.end_of(line.request(kStatusWord)).value, 0x0007u) << "bit 15 is 0";
  ASSERT_TRUE(line.run_until([&] { return line.slave().supervision.synchronized(); }));
  EXPECT_EQ(line.end_of(line.request(kStatusWord)).value, 0x8007u);
}

TEST_P(SlaveAcceptance, S10WithItsEdgeAwayTheSlaveSendsNothingOutOfItsSlot) {
  SlaveLine line(GetParam());
  line.start();
  Fault fault = fault_soon(line, FaultKind::missing_sync, 2, 1000);
  fault.probability = 0.3;
  line.line().faults().add(fault);
  line.run(1000);
  EXPECT_GT(line.slave().supervision.missed_edges(), 200u);
  EXPECT_GT(line.judge.count[0x300], 500u);
}

// --- the ends of every range

TEST_P(SlaveAcceptance, S14SlaveZeroAndSlave31) {
  for (const unsigned number : {0u, 31u}) {
    SlaveLine line(GetParam(), number);
    with_parameters(line);
    line.start();
    line.run(100);
    EXPECT_GT(line.one().sent, 100u);
    EXPECT_EQ(line.end_of(line.request(401)).value, 0xCAFEF00Du);
    EXPECT_EQ(line.ends.newest.value[0], 0x1000u);
  }
}

TEST_P(SlaveAcceptance, S27SubSlavesAndTheHighestParameterNumber) {
  SlaveLine line(GetParam());
  with_parameters(line);
  line.under_test.service.jobs.sub_slaves = true;
  line.start();
  line.slave().service.set_application(true);
  line.slave().application = [](SlaveNode& node) {
    if (!node.parameter) return;
    node.service.jobs().answer(node.parameter->id,
                               {false, ParameterError::none, true, node.parameter->sub_slave.value});
    node.parameter.reset();
  };
  for (const std::uint16_t sub : {std::uint16_t{1}, std::uint16_t{65535}}) {
    auto request = line.request(4095);
    request.sub_slave.value = sub;
    EXPECT_EQ(line.end_of(request).value, sub);
  }
  auto data = bytes_of(6);
  auto transfer = line.transfer(true, data);
  transfer.sub_slave.value = 65535;
  EXPECT_EQ(line.end_of(transfer).error, TransferError::not_possible) << "no gateway is behind this slave";
}

TEST_P(SlaveAcceptance, S15EmptyTelegramsPollAndAreAnswered) {
  SlaveLine line(GetParam());
  line.under_test.slave.full_length = false;
  line.under_test.slave.actual_mapping = {};
  line.master_settings.references = {};
  line.master_settings.master.process.poll_without_reference = true;
  line.master_settings.master.process.full_length = false;
  line.start();
  line.run(50);
  EXPECT_GT(line.judge.count[0x300], 50u);
  EXPECT_EQ(line.one().sent, line.one().asked);
  EXPECT_EQ(line.slave().supervision.missed_references(), 0u) << "none ever came";
}

TEST_P(SlaveAcceptance, S19AControlWordReachesTheSlave) {
  SlaveLine line(GetParam());
  line.start();
  cansync::ControlWordRequest request;
  request.id = 99;
  request.slave = line.under_test.slave.number;
  request.control_word = 0x000F;
  EXPECT_EQ(line.master().submit(request), cansync::Refusal::none);
  line.run(10);
  EXPECT_EQ(line.slave().control_words, std::vector<std::uint16_t>{0x000F});
}

}  // namespace
}  // namespace sim::test
