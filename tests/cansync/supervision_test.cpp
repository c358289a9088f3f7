// Slaves that stop answering: what becomes of their jobs, and of everybody else's.
#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "master_rig.h"

namespace cansync::test {
namespace {

using Code = MasterEvent::Code;

/// Drives that answer every parameter and transfer telegram, unless they are dead.
struct Drives {
  SlaveMask dead;
  SlaveMask unsynchronized;

  std::optional<Telegram> operator()(const Telegram& telegram) const {
    if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
      if (dead.has(command->slave)) return std::nullopt;
      if (command->kind != ParameterCommand::Kind::read) return MasterRig::written_reply(*command);
      return MasterRig::word_reply(*command, unsynchronized.has(command->slave) ? 0x0007 : 0x8007);
    }
    if (const auto* initialise = std::get_if<TransferInitialise>(&telegram)) {
      return acknowledge(initialise->slave, {});
    }
    if (const auto* block = std::get_if<DownloadBlock>(&telegram)) {
      return acknowledge(block->slave, block->offset);
    }
    return std::nullopt;
  }

 private:
  std::optional<Telegram> acknowledge(SlaveNumber slave, BlockOffset offset) const {
    if (dead.has(slave)) return std::nullopt;
    TransferReply reply;
    reply.slave = slave;
    reply.offset = offset;
    return reply;
  }
};

struct LostSlaves : testing::Test {
  MasterSettings settings = settings_for(4);
  std::shared_ptr<Drives> drives = std::make_shared<Drives>();
  std::unique_ptr<MasterRig> rig;
  std::vector<std::uint8_t> data = std::vector<std::uint8_t>(600, 0x5A);

  void start() {
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [drives = drives](const Telegram& t) { return (*drives)(t); };
    rig->activate();
  }
  Refusal read(JobId id, unsigned from) {
    return rig->master.submit(ParameterRequest{.id = id, .slave = slave(from), .number = parameter(5)});
  }
  Refusal download(JobId id, unsigned to) {
    return rig->master.submit(TransferRequest{.id = id,
                                              .direction = TransferRequest::Direction::download,
                                              .slave = slave(to),
                                              .address = 0x1000,
                                              .data = data});
  }
  bool lost(unsigned n) const { return rig->master.slave(slave(n)).state == SlaveState::lost; }
};

TEST_F(LostSlaves, RunningAndQueuedJobsOfEveryKindEndAsLostAtOnceAndAreCounted) {
  settings.command_channel.control_word.kind = Cursor::Kind::nobody;  // control words wait
  start();
  drives->dead.set(slave(1));
  for (JobId id = 1; id <= 5; ++id) ASSERT_EQ(read(id, 1), Refusal::none);
  for (JobId id = 11; id <= 12; ++id) ASSERT_EQ(download(id, 1), Refusal::none);
  ASSERT_EQ(rig->master.submit(ControlWordRequest{21, slave(1), 0x000F}), Refusal::none);
  const unsigned intervals = rig->run_until([this] { return lost(1); }, 20);
  EXPECT_LE(intervals, 2u * settings.startup.lost_after);
  for (JobId id = 1; id <= 5; ++id) EXPECT_EQ(rig->told.parameters.at(id).outcome, Outcome::slave_lost) << id;
  for (JobId id = 11; id <= 12; ++id)
    EXPECT_EQ(rig->told.transfers.at(id).outcome, Outcome::slave_lost) << id;
  EXPECT_EQ(rig->told.commands.at(21), Outcome::slave_lost);
  EXPECT_EQ(rig->told.terminal, 8u);
  const SlaveStatus& status = rig->master.slave(slave(1));
  EXPECT_EQ(status.times_lost, 1u);
  EXPECT_EQ(status.times_returned, 0u);
  EXPECT_EQ(status.jobs_ended, 8u);
  EXPECT_EQ(status.unanswered, settings.startup.lost_after);
  ASSERT_EQ(rig->told.count(Code::slave_lost), 1u);
  const auto& events = rig->told.events;
  const auto event = std::find_if(events.begin(), events.end(),
                                  [](const MasterEvent& e) { return e.code == Code::slave_lost; });
  EXPECT_EQ(event->detail, 8u);
}

TEST_F(LostSlaves, AWriteOnItsWayEndsWithoutAnAnswerAndOneThatWasNotSentAsLost) {
  settings.command_channel.repeat_unanswered_writes = true;
  start();
  drives->dead.set(slave(1));
  for (JobId id = 1; id <= 2; ++id) {
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id,
                                                  .write = true,
                                                  .slave = slave(1),
                                                  .number = parameter(5),
                                                  .format = ParameterFormat::word,
                                                  .value = 7}),
              Refusal::none);
  }
  rig->run_until([this] { return lost(1); }, 20);
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::no_answer);
  EXPECT_EQ(rig->told.parameters.at(2).outcome, Outcome::slave_lost);
}

TEST_F(LostSlaves, WhatIsAskedOfALostSlaveIsRefusedUntilItAnswersAgain) {
  settings.startup.status_period = std::chrono::milliseconds(50);
  start();
  drives->dead.set(slave(1));
  ASSERT_EQ(read(1, 1), Refusal::none);
  rig->run_until([this] { return lost(1); }, 20);
  EXPECT_EQ(read(2, 1), Refusal::slave_lost);
  EXPECT_EQ(download(3, 1), Refusal::slave_lost);
  EXPECT_EQ(rig->master.submit(ControlWordRequest{4, slave(1), 0x000F}), Refusal::slave_lost);
  EXPECT_EQ(rig->master.submit(BroadcastRequest{7, 1, {SlaveMask{0x3}, kCommandControlWord, 0, 0x000F}}),
            Refusal::slave_lost);
  EXPECT_EQ(read(5, 0), Refusal::none);
  drives->dead = {};
  rig->run_until([this] { return rig->master.slave(slave(1)).responds; }, 60);
  EXPECT_EQ(read(6, 1), Refusal::none);
  rig->run(5);
  EXPECT_EQ(rig->told.parameters.at(6).outcome, Outcome::done);
  EXPECT_EQ(rig->master.slave(slave(1)).times_returned, 1u);
}

TEST_F(LostSlaves, ControlWordsThatStopADriveAreSentAlsoWhenItsAnswersDoNotCome) {
  settings.command_channel.control_word.kind = Cursor::Kind::nobody;  // words that enable wait
  start();
  drives->dead.set(slave(1));
  ASSERT_EQ(rig->master.submit(ControlWordRequest{2, slave(1), 0x000F}), Refusal::none);
  ASSERT_EQ(read(4, 1), Refusal::none);
  rig->run_until([this] { return lost(1); }, 20);
  ASSERT_TRUE(lost(1));
  EXPECT_EQ(rig->told.commands.at(2), Outcome::slave_lost);
  EXPECT_EQ(rig->master.submit(ControlWordRequest{5, slave(1), 0}), Refusal::none);
  EXPECT_EQ(rig->master.submit(BroadcastRequest{6, 0, {SlaveMask{0xF}, kCommandControlWord, 0, 0}}),
            Refusal::none);
  rig->run(2);
  for (const JobId id : {5u, 6u}) EXPECT_EQ(rig->told.commands.at(id), Outcome::done) << id;
}

TEST_F(LostSlaves, OneLostTelegramEndsNoJob) {
  start();
  unsigned asked = 0;
  rig->answer = [this, &asked](const Telegram& t) -> std::optional<Telegram> {
    // Two of three answers of slave 1 are lost on the way.
    const auto* command = std::get_if<ParameterCommand>(&t);
    if (command != nullptr && command->slave == slave(1) && ++asked % 3 != 0) return std::nullopt;
    return (*drives)(t);
  };
  for (JobId id = 1; id <= 20; ++id) ASSERT_EQ(read(id, 1), Refusal::none);
  rig->run_until([this] { return rig->told.terminal == 20; }, 200);
  for (JobId id = 1; id <= 20; ++id) EXPECT_EQ(rig->told.parameters.at(id).outcome, Outcome::done) << id;
  EXPECT_EQ(rig->told.count(Code::slave_lost), 0u);
}

TEST_F(LostSlaves, JobsOfTheOthersAreServedAsIfADeadSlaveWereNotThere) {
  const auto intervals_for_jobs = [this](bool dead) {
    drives->dead = {};
    start();
    if (dead) {
      drives->dead.set(slave(1));
      EXPECT_EQ(read(1, 1), Refusal::none);
      rig->run_until([this] { return lost(1); }, 20);
      rig->run(5);
    }
    for (JobId id = 100; id < 160; ++id) EXPECT_EQ(read(id, id % 2 == 0 ? 0 : 2), Refusal::none);
    EXPECT_EQ(download(200, 3), Refusal::none);
    return rig->run_until(
        [this] { return rig->told.transfers.contains(200) && rig->told.parameters.contains(159); }, 1000);
  };
  const unsigned alone = intervals_for_jobs(false);
  const unsigned beside = intervals_for_jobs(true);
  EXPECT_EQ(beside, alone);
  // 60 parameters, 100 blocks in two initialises, and one interval for the last answer.
  EXPECT_LE(alone, 60u + 102u + 3u);
}

TEST_F(LostSlaves, ADeadSlaveIsAskedOnceAPeriodAlsoWhenTheChannelIsBusy) {
  settings.startup.status_period = std::chrono::milliseconds(100);
  start();
  drives->dead.set(slave(1));
  ASSERT_EQ(read(1, 1), Refusal::none);
  rig->run_until([this] { return lost(1); }, 20);
  unsigned asked = 0;
  constexpr unsigned kIntervals = 1000;
  for (unsigned i = 0; i < kIntervals; ++i) {
    // Refused while the queue is full, which also means that one is waiting.
    static_cast<void>(rig->master.submit(ControlWordRequest{1000 + i, slave(0), 0}));
    rig->step();
    const auto* command = rig->command() != nullptr ? std::get_if<ParameterCommand>(rig->command()) : nullptr;
    if (command != nullptr && command->slave == slave(1)) ++asked;
  }
  EXPECT_GE(asked, 8u);
  EXPECT_LE(asked, kIntervals / 100);
  drives->dead = {};
  rig->run_until([this] { return rig->master.slave(slave(1)).state == SlaveState::released; }, 400);
}

TEST_F(LostSlaves, ASlaveThatDiesBesideABusyChannelIsNoticedByItsMissingActualValues) {
  start();
  const auto poll = [this](std::uint32_t i) {
    ReferenceUpdate update;
    update.value = {i};
    update.valid_mask = 1;
    EXPECT_EQ(rig->master.submit(update), Refusal::none);
  };
  rig->answer = [this](const Telegram& t) -> std::optional<Telegram> {
    if (const auto* reference = std::get_if<ReferenceTelegram>(&t)) {
      const auto polled = SlaveNumber::from(reference->polled);
      if (!polled || drives->dead.has(*polled)) return std::nullopt;
      ActualTelegram actual;
      actual.slave = *polled;
      actual.channel = reference->channel;
      actual.words = 4;
      return actual;
    }
    return (*drives)(t);
  };
  drives->dead.set(slave(2));
  std::uint32_t i = 0;
  for (; i < 1000 && !lost(2); ++i) {
    poll(i);
    static_cast<void>(rig->master.submit(ControlWordRequest{1000 + i, slave(0), 0}));
    rig->step();
  }
  EXPECT_TRUE(lost(2));
  EXPECT_LE(i, 400u) << "three status words, one every 100 ms";
}

TEST_F(LostSlaves, ASlaveThatAnswersSomethingElseIsNotGone) {
  start();
  rig->answer = [this](const Telegram& t) -> std::optional<Telegram> {
    const auto* command = std::get_if<ParameterCommand>(&t);
    if (command == nullptr || command->number != parameter(5)) return (*drives)(t);
    ParameterCommand other = *command;
    other.number = parameter(6);
    return MasterRig::word_reply(other, 1);
  };
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1,
                                                .slave = slave(1),
                                                .number = parameter(5),
                                                .monitoring_time = std::chrono::milliseconds(50)}),
            Refusal::none);
  rig->run_until([this] { return rig->told.terminal == 1; }, 100);
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::timeout);
  EXPECT_EQ(rig->told.count(Code::slave_lost), 0u);
}

TEST_F(LostSlaves, AnInterruptedTransferSaysHowFarItCameInWholeBlocks) {
  start();
  ASSERT_EQ(download(1, 2), Refusal::none);
  rig->run(70);  // one initialise and 50 telegrams a block of 300 bytes
  drives->dead.set(slave(2));
  rig->run_until([this] { return lost(2); }, 20);
  const TransferResult& result = rig->told.transfers.at(1);
  EXPECT_EQ(result.outcome, Outcome::no_answer) << "a part of it is in the slave";
  EXPECT_EQ(result.bytes, 300u);
  EXPECT_GT(result.error_offset, 300u);
  EXPECT_LT(result.error_offset, 600u);
}

}  // namespace
}  // namespace cansync::test
