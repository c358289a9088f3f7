// What programs ask of the slave itself, on a simulated line, in virtual time.
#include "daemon/cansync_slave/realtime/slave_commands.h"

#include <gtest/gtest.h>

#include <variant>
#include <vector>

#include "slave_rig.h"

namespace cansyncd {
namespace {

using namespace test;
using cansync::State;

/// A rig whose answers are taken.
struct CommandRig : SlaveRig {
  void order(can::Time when, SlaveOrder order) {
    at(when, [this, order] { EXPECT_TRUE(exchange.commands.try_push(order)); });
  }
  void run(can::Time end) {
    run_until(end);
    SlaveOrderDone done;
    while (exchange.done.try_pop(done)) answers.push_back(done);
  }
  std::vector<SlaveOrderDone> answers;
};

const cansync::ProcessMapping kBothTelegrams = {cansync::default_mapping(cansync::Channel::one),
                                                cansync::default_mapping(cansync::Channel::two)};

/// The commands of a slave that is active, without a loop.
struct CoreRig {
  CoreRig(SlaveRig& rig, bool of_cluster) : CoreRig(rig, of_cluster, *rig.bus) {}
  CoreRig(SlaveRig& rig, bool of_cluster, can::Bus& bus)
      : desk({}, 301, 0, rig.exchange),
        slave({}, desk.application()),
        commands(slave, bus, rig.exchange, SlaveTarget::active, of_cluster) {
    commands.set_up();
  }
  SlaveDesk desk;
  cansync::Slave slave;
  SlaveCommands commands;
};

std::uint64_t id_of(const SlaveOrderDone& done) {
  return std::visit([](const auto& order) { return order.id; }, done.order);
}

TEST(SlaveCommandsTest, S3TheModeIsSetWhileItRunsAndEachOrderIsAnsweredOnce) {
  CommandRig rig;
  const can::Time interval = rig.times.interval;
  rig.order(1500 * interval, SlaveModeOrder{1, SlaveMode::stop});
  State stopped = State::start_up;
  rig.at(1505 * interval, [&] {
    EXPECT_TRUE(rig.exchange.status.read(rig.snapshot));
    stopped = rig.snapshot.state;
    EXPECT_FALSE(rig.snapshot.activated);
    EXPECT_EQ(rig.snapshot.status_word, 0) << "bit 15 is clear";
  });
  rig.order(1510 * interval, SlaveModeOrder{2, SlaveMode::run});
  rig.order(1520 * interval, SlaveModeOrder{3, SlaveMode::setup});
  rig.order(1530 * interval, SlaveModeOrder{4, SlaveMode::run});
  rig.run(1540 * interval);
  EXPECT_EQ(stopped, State::waiting_for_start);
  EXPECT_EQ(rig.snapshot.state, State::active_slave);
  ASSERT_EQ(rig.answers.size(), 4u);
  for (std::size_t i = 0; i < rig.answers.size(); ++i) EXPECT_EQ(id_of(rig.answers[i]), i + 1);
  EXPECT_EQ(rig.answers[1].refusal, SlaveRefusal::wrong_state)
      << "active operation follows from set-up alone";
  EXPECT_EQ(rig.answers[3].refusal, SlaveRefusal::none);
  const auto states = rig.told<SlaveStateReport>();
  // The start, what each order made, and the end of the loop.
  ASSERT_EQ(states.size(), 5u);
  EXPECT_EQ(states[1].to, State::waiting_for_start);
  EXPECT_EQ(states[2].to, State::setting_up_slave);
  EXPECT_EQ(states[3].to, State::active_slave);
}

TEST(SlaveCommandsTest, S4ARestartGoesAsFarAsTheConfigurationSaysAndSetUpIsReachedFromActive) {
  CommandRig rig;
  const can::Time interval = rig.times.interval;
  rig.order(1500 * interval, SlaveModeOrder{1, SlaveMode::setup});
  rig.order(1505 * interval, SlaveModeOrder{2, SlaveMode::restart});
  rig.order(1506 * interval, SlaveModeOrder{3, SlaveMode::reset_can});
  rig.run(1510 * interval);
  ASSERT_EQ(rig.answers.size(), 3u);
  for (const SlaveOrderDone& done : rig.answers) EXPECT_EQ(done.refusal, SlaveRefusal::none);
  EXPECT_EQ(rig.snapshot.state, State::active_slave);
}

TEST(SlaveCommandsTest, S16ARestartLeavesNothingReleasedThatWasReleasedBefore) {
  CommandRig rig;
  const can::Time interval = rig.times.interval;
  rig.at(1490 * interval, [&rig] {
    for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}}) rig.master->set_reference(value, {});
  });
  rig.at(1499 * interval, [&rig] {
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two})
      EXPECT_TRUE(rig.exchange.releases.try_push({channel, {7, 8, 0, 0}, 0x03, 900}));
  });
  rig.order(1505 * interval, SlaveModeOrder{1, SlaveMode::restart});
  rig.at(1510 * interval,
         [&rig] { rig.master->set_reference(0, {.kind = sim::ReferenceCurve::Kind::constant}); });
  rig.run(1600 * interval);
  EXPECT_EQ(rig.snapshot.state, State::active_slave);
  EXPECT_EQ(rig.snapshot.unused[0], 1u);
  EXPECT_EQ(rig.snapshot.unused[1], 1u);
  EXPECT_TRUE(rig.trace.starts(cansync::identifier::actual_one + kNumber).empty());
}

/// The master stops giving reference values, or gives them, when it likes while the slave is not active.
TEST(SlaveCommandsTest, S12WithoutActiveOperationNoReferenceValueIsMissing) {
  for (const bool fault_stands : {false, true}) {
    CommandRig rig;
    const can::Time interval = rig.times.interval;
    rig.at((fault_stands ? 1470 : 1498) * interval, [&rig] {
      for (const std::uint8_t value : {std::uint8_t{0}, std::uint8_t{4}})
        rig.master->set_reference(value, {});
    });
    rig.order(1500 * interval, SlaveModeOrder{1, SlaveMode::setup});
    rig.order(1550 * interval, SlaveModeOrder{2, SlaveMode::run});
    rig.run(1600 * interval);
    ASSERT_EQ(rig.answers.size(), 2u);
    EXPECT_EQ(rig.snapshot.state, State::active_slave);
    EXPECT_EQ(rig.snapshot.fault, cansync::SlaveFault::none);
    EXPECT_EQ(rig.snapshot.missing_in_row, 0u);
    const auto faults = rig.told<FaultReport>();
    ASSERT_EQ(faults.size(), fault_stands ? 2u : 0u);
    if (!fault_stands) continue;
    EXPECT_TRUE(faults[1].over);
    EXPECT_EQ(faults[1].when.bus / interval, 1500);
  }
}

// S18: any time; in force with the next interval at the latest.
TEST(SlaveCommandsTest, S18AMappingIsInForceWithTheNextInterval) {
  CommandRig rig;
  const can::Time interval = rig.times.interval;
  // The low word of value 3 stands where that of value 0 stood; the master's mapping stays.
  SlaveMappingOrder order{1, kBothTelegrams, kBothTelegrams};
  order.reference[0].word = {};
  order.reference[0].word[0] = {true, false, 3};
  rig.order(1500 * interval + interval / 2, order);
  rig.run(1510 * interval);
  ASSERT_EQ(rig.answers.size(), 1u);
  EXPECT_EQ(rig.answers[0].refusal, SlaveRefusal::none);
  std::uint32_t frozen = 0;
  unsigned after = 0;
  for (const ReferencesReport& report : rig.told<ReferencesReport>()) {
    if (report.values.arrived != 1) continue;
    if ((report.values.words & 0x08) == 0) {
      frozen = report.values.values[0];
      EXPECT_EQ(report.values.values[3], 0u);
      continue;
    }
    ++after;
    EXPECT_EQ(report.values.values[0], frozen) << "a word that is not mapped leaves the value as it was";
    EXPECT_EQ(report.values.values[3], frozen + after);
  }
  EXPECT_GE(after, 8u) << "from the next interval on";
}

TEST(SlaveCommandsTest, S17ListeningBeginsAndEndsWhileItRuns) {
  SlaveRig rig;
  CoreRig core(rig, false);
  const auto other = *cansync::SlaveNumber::from(9);
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveListenOrder{1, other, kBothTelegrams}));
  ASSERT_TRUE(core.commands.take());
  cansync::ActualTelegram telegram;
  telegram.slave = other;
  telegram.words = 4;
  telegram.word[0] = 77;
  (void)core.slave.receive(telegram, {});
  EXPECT_EQ(core.slave.monitored(other)[0], 77u);
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveListenOrder{2, other, std::nullopt}));
  ASSERT_TRUE(core.commands.take());
  telegram.word[0] = 78;
  (void)core.slave.receive(telegram, {});
  EXPECT_EQ(core.slave.monitored(other)[0], 77u);
}

TEST(SlaveCommandsTest, TheControllerOfAClustersSlaveMayBeReset) {
  SlaveRig rig;
  CoreRig core(rig, true);
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{7, SlaveMode::reset_can}));
  const auto done = core.commands.take();
  ASSERT_TRUE(done);
  EXPECT_EQ(done->refusal, SlaveRefusal::none);
  EXPECT_EQ(core.slave.state(), State::active_slave);
}

TEST(SlaveCommandsTest, TheSlaveOfAClusterTakesNoOther) {
  SlaveRig rig;
  CoreRig core(rig, true);
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{7, SlaveMode::stop}));
  const auto done = core.commands.take();
  ASSERT_TRUE(done);
  EXPECT_EQ(done->refusal, SlaveRefusal::of_cluster);
  EXPECT_EQ(core.slave.state(), State::active_slave);
  EXPECT_FALSE(core.commands.take());
}

/// A bus whose controller is reset with this result; at first it takes its time.
class ResetBus final : public can::Bus {
 public:
  can::Time now() noexcept override { return can::Time{0}; }
  can::Wake wait_until(can::Time) noexcept override { return can::Wake::deadline; }
  bool receive(can::ReceivedFrame&) noexcept override { return false; }
  can::SendResult send(const can::Frame&) noexcept override { return can::SendResult::queued; }
  can::ControllerStatus status() noexcept override { return {}; }
  can::ResetResult reset() noexcept override { return result; }
  can::ResetResult reset_result() noexcept override { return result; }
  can::TimestampSource timestamp_source() noexcept override { return can::TimestampSource::thread; }

  can::ResetResult result = can::ResetResult::pending;
};

TEST(SlaveCommandsTest, AControllerThatCannotBeResetIsResetWhenItsInterfaceIsUp) {
  SlaveRig rig;
  ResetBus bus;
  CoreRig core(rig, false, bus);
  const auto ask = [&](std::uint64_t id) {
    EXPECT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{id, SlaveMode::reset_can}));
    return core.commands.take();
  };
  bus.result = can::ResetResult::unavailable;
  const auto refused = ask(7);
  bus.result = can::ResetResult::done;
  const auto done = ask(8);
  ASSERT_TRUE(refused && done);
  EXPECT_EQ(refused->refusal, SlaveRefusal::no_controller);
  EXPECT_EQ(done->refusal, SlaveRefusal::none);
}

// An order that is stopped says what is known of it: a reset that was begun may be done, those behind it are not.
TEST(SlaveCommandsTest, WhatIsStoppedBeforeItsEndSaysWhatIsKnownOfIt) {
  SlaveRig rig;
  ResetBus bus;
  CoreRig core(rig, false, bus);
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{7, SlaveMode::reset_can}));
  ASSERT_TRUE(rig.exchange.commands.try_push(SlaveModeOrder{8, SlaveMode::stop}));
  EXPECT_FALSE(core.commands.take()) << "the reset is under way, and the other one waits for it";
  const auto reset = core.commands.take_stopped();
  const auto behind = core.commands.take_stopped();
  ASSERT_TRUE(reset && behind);
  EXPECT_EQ(id_of(*reset), 7u);
  EXPECT_EQ(reset->stopped, can::JobKnown::handed_over);
  EXPECT_EQ(id_of(*behind), 8u);
  EXPECT_EQ(behind->stopped, can::JobKnown::not_sent);
  EXPECT_EQ(core.slave.state(), State::active_slave) << "nothing of it was done";
  EXPECT_FALSE(core.commands.take_stopped());
}

TEST(SlaveCommandsTest, WhatWaitsWhenTheLoopEndsIsAnsweredAsNotBegun) {
  CommandRig rig;
  const can::Time end = 1500 * rig.times.interval;
  rig.order(end, SlaveModeOrder{9, SlaveMode::stop});
  rig.run(end);
  ASSERT_EQ(rig.answers.size(), 1u);
  EXPECT_EQ(id_of(rig.answers[0]), 9u);
  EXPECT_EQ(rig.answers[0].stopped, can::JobKnown::not_sent);
}

}  // namespace
}  // namespace cansyncd
