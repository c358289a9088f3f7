#include "master_rig.h"

/// Control words that stop pass everything that waits, and every control word and broadcast has one answer.
namespace cansync::test {
namespace {

constexpr std::uint16_t kEnable = 0x000F;
constexpr std::uint16_t kStop = 0x0006;
constexpr Cursor kNobody{Cursor::Kind::nobody, {}};

/// An active line of four slaves that answer every parameter command.
class StopWords : public ::testing::Test {
 protected:
  void start() {
    settings.startup.status_period = Duration(0);
    settings.startup.lost_after = 255;  // its slaves answer no transfers
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [](const Telegram& telegram) -> std::optional<Telegram> {
      const auto* command = std::get_if<ParameterCommand>(&telegram);
      if (command == nullptr) return std::nullopt;
      return MasterRig::word_reply(*command, 0x8001);
    };
    rig->activate();
  }

  Refusal word(JobId id, unsigned to, std::uint16_t value, Duration time = {}, bool failsafe = false) {
    return rig->master.submit(ControlWordRequest{id, slave(to), value, time, failsafe});
  }
  Refusal broadcast(JobId id, std::uint8_t priority, std::uint32_t mask, std::uint16_t value) {
    return rig->master.submit(
        BroadcastRequest{id, priority, {SlaveMask{mask}, kCommandControlWord, 0, value}, {}});
  }
  std::optional<Outcome> outcome(JobId id) const {
    const auto found = rig->told.commands.find(id);
    return found == rig->told.commands.end() ? std::nullopt : std::optional(found->second);
  }
  /// Intervals until the control word or broadcast is answered.
  unsigned intervals_until(JobId id, unsigned most = 2000) {
    return rig->run_until([&] { return outcome(id).has_value(); }, most);
  }
  /// The slaves whose control words went out in the next `intervals` intervals, in their order.
  std::vector<unsigned> words_sent(unsigned intervals) {
    std::vector<unsigned> order;
    for (unsigned i = 0; i < intervals; ++i) {
      rig->step();
      const auto* action = rig->command() != nullptr ? std::get_if<ActionCommand>(rig->command()) : nullptr;
      if (action != nullptr) order.push_back(static_cast<unsigned>(__builtin_ctz(action->slaves.bits)));
    }
    return order;
  }

  MasterSettings settings = settings_for(4);
  std::unique_ptr<MasterRig> rig;
};

TEST_F(StopWords, PassEveryCursor) {
  const Cursor fixed{Cursor::Kind::fixed, slave(2)};
  for (const Serving serving : {Serving::scan, Serving::work_conserving}) {
    for (const Cursor& cursor : {Cursor{}, fixed, kNobody}) {
      settings.command_channel.serving = serving;
      settings.command_channel.control_word = cursor;
      start();
      for (unsigned to = 0; to < 4; ++to) {
        ASSERT_EQ(word(10 + to, to, kStop), Refusal::none);
        EXPECT_EQ(intervals_until(10 + to), 1u) << "to slave " << to;
        EXPECT_EQ(outcome(10 + to), Outcome::done);
      }
    }
  }
}

TEST_F(StopWords, ThoseOfTheFailsafeReactionPassTheCursorWhateverTheirBitsAre) {
  settings.command_channel.control_word = kNobody;
  start();
  ASSERT_EQ(word(1, 3, kEnable, {}, true), Refusal::none);
  EXPECT_EQ(intervals_until(1), 1u);
  EXPECT_EQ(outcome(1), Outcome::done);
}

TEST_F(StopWords, OneAloneIsSentInTheNextIntervalButOneWhateverElseWaits) {
  settings.command_channel.minimum_share = 2;
  start();
  static std::array<std::uint8_t, 40'000> data;
  ASSERT_EQ(rig->master.submit(TransferRequest{.id = 1, .slave = slave(1), .address = 0x1000, .data = data}),
            Refusal::none);
  JobId id = 100;
  for (unsigned round = 0; round < 200; ++round) {
    for (unsigned i = 0; i < 4; ++i) {
      static_cast<void>(
          rig->master.submit(ParameterRequest{.id = ++id, .slave = slave(id % 4), .number = parameter(5)}));
      for (const std::uint8_t priority : std::to_array<std::uint8_t>({0, 1, 2})) {
        static_cast<void>(broadcast(++id, priority, 1, kEnable));
      }
    }
    rig->run(round % 5);
    const JobId stop = ++id;
    ASSERT_EQ(word(stop, 3, kStop), Refusal::none);
    EXPECT_LE(intervals_until(stop), 2u) << round;
    EXPECT_EQ(outcome(stop), Outcome::done);
  }
}

TEST_F(StopWords, ThoseOfSeveralSlavesGoOneAnIntervalInTheirOrderBeforeEveryShare) {
  settings = settings_for(32);
  settings.command_channel.minimum_share = 2;
  settings.command_channel.control_word = kNobody;
  start();
  for (JobId id = 1; id <= 50; ++id) {
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id, .slave = slave(2), .number = parameter(5)}),
              Refusal::none);
  }
  for (unsigned to = 32; to-- > 0;) ASSERT_EQ(word(100 + to, to, kStop), Refusal::none);
  std::vector<unsigned> expected(32);
  for (unsigned i = 0; i < 32; ++i) expected[i] = 31 - i;
  EXPECT_EQ(words_sent(32), expected);
}

TEST_F(StopWords, OnesGivenLaterToOtherSlavesDoNotGoFirst) {
  settings = settings_for(32);
  start();
  // Slave 3 had one just before, so that others may go before its second.
  ASSERT_EQ(word(1, 3, kStop), Refusal::none);
  ASSERT_EQ(intervals_until(1), 1u);
  ASSERT_EQ(word(2, 3, kStop), Refusal::none);
  JobId id = 100;
  for (unsigned to = 4; to < 12 && !outcome(2); ++to) {
    ASSERT_EQ(word(++id, to, kStop), Refusal::none);
    ASSERT_EQ(broadcast(++id, 1, 1, kStop), Refusal::none);
    rig->step();
  }
  EXPECT_EQ(outcome(2), Outcome::done);
  EXPECT_EQ(words_sent(1).size(), 1u) << "of those given later the first";
  EXPECT_LE(id, 104u) << "within two intervals";
}

TEST_F(StopWords, OneOtherCommandAtMostGoesBeforeSeveralWhoseSlavesHadOneJustBefore) {
  settings.command_channel.minimum_share = 2;
  start();
  for (JobId id = 1; id <= 50; ++id) {
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id, .slave = slave(2), .number = parameter(5)}),
              Refusal::none);
  }
  for (unsigned to = 0; to < 3; ++to) ASSERT_EQ(word(100 + to, to, kStop), Refusal::none);
  ASSERT_EQ(intervals_until(102), 3u);
  for (unsigned to = 0; to < 3; ++to) ASSERT_EQ(word(200 + to, to, kStop), Refusal::none);
  EXPECT_EQ(intervals_until(202), 4u) << "three words and a parameter";
}

TEST_F(StopWords, ANewerOneOfTheSameSlaveTakesTheTurnOfTheOneItReplaces) {
  settings.command_channel.control_word = kNobody;
  start();
  ASSERT_EQ(word(1, 2, kStop), Refusal::none);
  ASSERT_EQ(word(2, 1, kStop), Refusal::none);
  ASSERT_EQ(word(3, 2, 0), Refusal::none);
  EXPECT_EQ(words_sent(2), (std::vector<unsigned>{2, 1}));
  EXPECT_EQ(outcome(1), Outcome::replaced);
}

TEST_F(StopWords, WithBroadcastsZeroWithoutEndTheyTakeTurns) {
  settings.command_channel.control_word = kNobody;
  start();
  JobId id = 100;
  for (unsigned to = 0; to < 4; ++to) ASSERT_EQ(word(10 + to, to, kStop), Refusal::none);
  for (unsigned i = 0; i < 8; ++i) {
    ASSERT_EQ(rig->master.submit(BroadcastRequest{++id, 0, {SlaveMask{0xF}, 200, 0, 0}, {}}), Refusal::none);
    rig->step();
  }
  for (unsigned to = 0; to < 4; ++to) EXPECT_EQ(outcome(10 + to), Outcome::done) << to;
}

TEST_F(StopWords, GivenWithoutEndToEverySlaveTheyLeaveTheOthersAShare) {
  settings = settings_for(32);
  start();
  static std::array<std::uint8_t, 4'000> data;
  ASSERT_EQ(rig->master.submit(TransferRequest{.id = 1, .slave = slave(1), .address = 0x1000, .data = data}),
            Refusal::none);
  JobId id = 100;
  unsigned parameters = 0;
  unsigned transfers = 0;
  for (unsigned i = 0; i < 330; ++i) {
    for (unsigned to = 0; to < 32; ++to) ASSERT_EQ(word(++id, to, kStop), Refusal::none);
    static_cast<void>(
        rig->master.submit(ParameterRequest{.id = ++id, .slave = slave(2), .number = parameter(5)}));
    rig->step();
    parameters += std::holds_alternative<ParameterCommand>(*rig->command()) ? 1 : 0;
    transfers += std::holds_alternative<TransferInitialise>(*rig->command()) ? 1 : 0;
  }
  EXPECT_EQ(parameters, 5u);
  EXPECT_EQ(transfers, 5u);
}

TEST_F(StopWords, AWordThatEnablesWaitsForTheCursorAndEndsWhenItsTimeIsOver) {
  settings.command_channel.control_word = kNobody;
  settings.command_channel.command_monitoring = std::chrono::milliseconds(50);
  start();
  ASSERT_EQ(word(1, 1, kEnable), Refusal::none);
  ASSERT_EQ(word(2, 2, kEnable, std::chrono::milliseconds(20)), Refusal::none);
  EXPECT_EQ(intervals_until(2), 21u);
  EXPECT_EQ(intervals_until(1), 30u);
  EXPECT_EQ(outcome(1), Outcome::timeout);
  EXPECT_EQ(outcome(2), Outcome::timeout);
  ASSERT_EQ(rig->master.set_command_cursors({}, {}, {}), Refusal::none);
  EXPECT_TRUE(words_sent(10).empty()) << "what was answered is not sent";
}

TEST_F(StopWords, ABroadcastThatCannotGoOutEndsWhenItsTimeIsOver) {
  settings.command_channel.minimum_share = 0;
  settings.command_channel.command_monitoring = std::chrono::milliseconds(10);
  start();
  ASSERT_EQ(broadcast(1, 2, 0xF, kStop), Refusal::none);
  for (JobId id = 100; id < 111; ++id) {
    ASSERT_EQ(rig->master.submit(BroadcastRequest{id, 1, {SlaveMask{1}, 200, 0, 0}, {}}), Refusal::none);
    rig->step();
  }
  rig->step();
  EXPECT_EQ(outcome(1), Outcome::timeout);
}

TEST_F(StopWords, TheNewestWordOfASlaveReplacesTheOneThatWaits) {
  settings.command_channel.control_word = kNobody;
  start();
  ASSERT_EQ(word(1, 3, kEnable), Refusal::none);
  ASSERT_EQ(word(2, 2, kEnable), Refusal::none);
  ASSERT_EQ(word(3, 3, kStop), Refusal::none);
  EXPECT_EQ(outcome(1), Outcome::replaced);
  ASSERT_EQ(word(4, 3, 0), Refusal::none);
  EXPECT_EQ(outcome(3), Outcome::replaced);
  EXPECT_EQ(words_sent(3), std::vector<unsigned>{3});
  EXPECT_EQ(outcome(4), Outcome::done);
  EXPECT_EQ(outcome(2), std::nullopt) << "another slave's";
}

TEST_F(StopWords, AStopIsNotFollowedByWhatWasGivenBeforeItAndEnables) {
  settings.command_channel.control_word = kNobody;
  start();
  ASSERT_EQ(broadcast(1, 2, 0b1010, kEnable), Refusal::none);
  ASSERT_EQ(broadcast(2, 1, 0b0010, kEnable), Refusal::none);
  ASSERT_EQ(broadcast(3, 1, 0b1000, kStop), Refusal::none) << "a stop of slave 3 alone";
  EXPECT_EQ(outcome(1), Outcome::replaced);
  EXPECT_EQ(outcome(2), std::nullopt);
  ASSERT_EQ(word(4, 1, kStop), Refusal::none);
  EXPECT_EQ(outcome(2), Outcome::replaced);
  rig->run(3);
  for (const JobId id : {3u, 4u}) EXPECT_EQ(outcome(id), Outcome::done) << id;
  ASSERT_EQ(word(5, 2, kEnable), Refusal::none);
  ASSERT_EQ(broadcast(6, 0, 0xF, kStop), Refusal::none);
  EXPECT_EQ(outcome(5), Outcome::replaced);
  ASSERT_EQ(broadcast(7, 1, 0xF, kEnable), Refusal::none) << "given after the stop";
  rig->run(2);
  EXPECT_EQ(outcome(7), Outcome::done);
}

TEST_F(StopWords, NoOtherWordTakesThePlaceOfTheFailsafeReactions) {
  start();
  ASSERT_EQ(word(1, 3, kEnable), Refusal::none);
  ASSERT_EQ(word(2, 3, kStop, {}, true), Refusal::none);
  EXPECT_EQ(outcome(1), Outcome::replaced);
  ASSERT_EQ(word(3, 3, kEnable), Refusal::none);
  ASSERT_EQ(word(4, 3, 0), Refusal::none);
  ASSERT_EQ(broadcast(5, 2, 0b1001, kEnable), Refusal::none);
  for (const JobId id : {3u, 4u, 5u}) EXPECT_EQ(outcome(id), Outcome::replaced) << id;
  ASSERT_EQ(word(6, 3, kStop, {}, true), Refusal::none) << "a new round";
  EXPECT_EQ(outcome(2), Outcome::replaced);
  EXPECT_EQ(words_sent(3), std::vector<unsigned>{3});
  EXPECT_EQ(outcome(6), Outcome::done);
  ASSERT_EQ(word(7, 3, kEnable), Refusal::none) << "it has been sent";
  EXPECT_EQ(words_sent(1), std::vector<unsigned>{3});
}

TEST_F(StopWords, DoneMeansSeenOnTheBusAndNoAnswerThatItWasNot) {
  start();
  rig->lose_echoes = true;
  ASSERT_EQ(word(1, 3, kEnable), Refusal::none);
  EXPECT_EQ(words_sent(1), std::vector<unsigned>{3});
  EXPECT_EQ(outcome(1), std::nullopt) << "handed over";
  ASSERT_EQ(broadcast(2, 0, 0b0001, kStop), Refusal::none);
  EXPECT_EQ(words_sent(1), std::vector<unsigned>{0});
  EXPECT_EQ(outcome(1), Outcome::no_answer);
  EXPECT_TRUE(words_sent(5).empty()) << "not sent again by itself";
  EXPECT_EQ(outcome(2), Outcome::no_answer);
  rig->lose_echoes = false;
  ASSERT_EQ(word(3, 3, kEnable), Refusal::none);
  rig->step();
  EXPECT_EQ(outcome(3), Outcome::done) << "at once";
}

TEST_F(StopWords, WhatWasHandedOverWhenTheMasterStopsEndsAsNotSeen) {
  start();
  rig->lose_echoes = true;
  ASSERT_EQ(word(1, 3, kStop), Refusal::none);
  ASSERT_EQ(word(2, 1, kStop), Refusal::none);
  rig->step();
  EXPECT_EQ(rig->master.cancel(1), Refusal::unknown_job) << "it is on its way";
  EXPECT_EQ(rig->master.cancel(2), Refusal::none);
  ASSERT_EQ(word(3, 0, kStop), Refusal::none);
  EXPECT_EQ(rig->master.control(ControlCommand::cold_restart), Refusal::none);
  EXPECT_EQ(outcome(1), Outcome::no_answer);
  EXPECT_EQ(outcome(2), Outcome::cancelled);
  EXPECT_EQ(outcome(3), Outcome::master_stopped);
}

}  // namespace
}  // namespace cansync::test
