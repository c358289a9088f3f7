// Two drives of one number, and drives that are not configured: found by their answers.
#include <algorithm>
#include <set>

#include "cansync/supervision/answer_balance.h"
#include "master_rig.h"

namespace cansync::test {
namespace {

using Code = MasterEvent::Code;

/// Three configured slaves, with more drives on the line than that. Answers come at once, those of the second
/// drive of a number right after those of the first.
struct WhoIsThere : testing::Test {
  MasterSettings settings = settings_for(3);
  std::unique_ptr<MasterRig> rig;
  SlaveMask present{0x7};
  SlaveMask twice;
  IntervalNumber locks = 0;        // in this interval the drives synchronize
  std::vector<SlaveNumber> asked;  // status words

  WhoIsThere() { settings.startup.status_period = std::chrono::milliseconds(20); }

  std::optional<Telegram> answer_to(const Telegram& telegram) {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr) return std::nullopt;
    asked.push_back(command->slave);
    if (!present.has(command->slave)) return std::nullopt;
    return MasterRig::word_reply(*command, rig->next_interval > locks ? 0x8007 : 0x0007);
  }
  void set_up() {
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [this](const Telegram& t) { return answer_to(t); };
    rig->second_answer = [this](const ParameterCommand& command) -> std::optional<Telegram> {
      if (!twice.has(command.slave)) return std::nullopt;
      return MasterRig::word_reply(command, 0x0001);
    };
    rig->set_up();
  }
  void step() { rig->step(); }
  void run(unsigned intervals) {
    for (unsigned i = 0; i < intervals; ++i) step();
  }
  Refusal enter_run() { return rig->master.control(ControlCommand::enable_active); }
  SlaveState state(unsigned n) const { return rig->master.slave(slave(n)).state; }
  unsigned times(Code code) const { return rig->told.count(code); }
};

TEST_F(WhoIsThere, TwoDrivesOfOneNumberAreFoundInSetUpAndKeepTheLineFromRun) {
  twice.set(slave(1));
  for (const EnableRule rule : {EnableRule::all_synchronized, EnableRule::all_responding, EnableRule::any}) {
    settings.startup.enable = rule;
    set_up();
    step();  // the activation
    for (unsigned i = 0; i < 40; ++i) {
      step();
      if (!rig->master.slave(slave(1)).responds) continue;
      ASSERT_EQ(enter_run(), Refusal::slaves_missing) << i;
    }
    EXPECT_EQ(times(Code::duplicate_slave), 1u);
    EXPECT_EQ(rig->master.duplicate_slaves().bits, 0x2u);
    EXPECT_EQ(state(1), SlaveState::held);
    EXPECT_EQ(rig->master.slave(slave(1)).held->code, Code::duplicate_slave);
    EXPECT_EQ(rig->master.submit(ControlWordRequest{1, slave(1), 0x000F}), Refusal::slave_held);
    EXPECT_EQ(state(0), SlaveState::released);
    EXPECT_EQ(rig->master.control(ControlCommand::enable_active, true), Refusal::none) << "by force";
  }
}

TEST_F(WhoIsThere, ASecondDriveThatComesInRunIsFoundAndHeld) {
  set_up();
  run(50);
  ASSERT_EQ(enter_run(), Refusal::none);
  run(100);
  ASSERT_EQ(times(Code::duplicate_slave), 0u);
  twice.set(slave(2));
  run(1000);
  EXPECT_EQ(times(Code::duplicate_slave), 1u);
  EXPECT_EQ(state(2), SlaveState::held);
  EXPECT_EQ(rig->master.state(), State::active_master) << "the line goes on";
}

TEST_F(WhoIsThere, TwoThatAnswerNoCommandAreHeldWhenTheyAnswerOne) {
  settings.startup.enable = EnableRule::any;
  present.set(slave(2), false);
  set_up();
  run(50);
  ASSERT_EQ(enter_run(), Refusal::none);
  for (unsigned i = 0; i < 40; ++i) {
    ReferenceUpdate update;
    update.valid_mask = 1;
    ASSERT_EQ(rig->master.submit(update), Refusal::none);
    step();
    for (unsigned drive = 0; drive < 2; ++drive) {
      ActualTelegram actual;
      actual.slave = slave(2);
      rig->master.receive(encode(actual), std::chrono::microseconds(600));
    }
  }
  EXPECT_EQ(times(Code::duplicate_slave), 0u);
  present.set(slave(2));
  twice.set(slave(2));
  run(1500);
  EXPECT_EQ(times(Code::duplicate_slave), 1u);
  EXPECT_EQ(state(2), SlaveState::held);
}

TEST_F(WhoIsThere, TwoThatSayNowThisNowThatStayHeld) {
  set_up();
  run(50);
  twice.set(slave(1));
  run(50);
  ASSERT_EQ(state(1), SlaveState::held);
  const auto events = rig->told.events.size();
  for (unsigned i = 0; i < 5; ++i) {
    locks = rig->next_interval + 100;  // the other drive answers first
    run(100);
    EXPECT_EQ(state(1), SlaveState::held);
    run(100);
    EXPECT_EQ(state(1), SlaveState::held);
  }
  EXPECT_EQ(
      std::count_if(rig->told.events.begin() + static_cast<std::ptrdiff_t>(events), rig->told.events.end(),
                    [](const MasterEvent& event) { return event.slave == slave(1); }),
      0);
}

TEST_F(WhoIsThere, AFrameThatCameTwiceOnceIsNoSecondDriveAndDelaysRunShortly) {
  set_up();
  twice.set(slave(1));
  run(3);
  twice = {};
  EXPECT_EQ(enter_run(), Refusal::slaves_missing) << "it may be one";
  run(20);
  EXPECT_EQ(enter_run(), Refusal::none);
  EXPECT_EQ(times(Code::duplicate_slave), 0u);
}

TEST_F(WhoIsThere, AnswersThatComeTwiceNowAndThenNeverAddUp) {
  set_up();
  run(30);
  ASSERT_EQ(enter_run(), Refusal::none);
  for (unsigned i = 0; i < 100; ++i) {
    twice.set(slave(1));
    const auto before = rig->told.events.size();
    run(20);
    twice = {};
    run(200);
    ASSERT_EQ(rig->told.events.size(), before);
  }
}

TEST_F(WhoIsThere, AReleaseLooksAgainAndForceGoesOnWithTwo) {
  twice.set(slave(1));
  set_up();
  run(50);
  ASSERT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  run(50);
  EXPECT_EQ(state(1), SlaveState::held) << "still two";
  EXPECT_EQ(times(Code::duplicate_slave), 2u);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  run(50);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_EQ(rig->master.duplicate_slaves().bits, 0x2u) << "and it says so";
  EXPECT_EQ(enter_run(), Refusal::none);
}

TEST_F(WhoIsThere, OneDriveIsLeftAndReleased) {
  twice.set(slave(1));
  set_up();
  run(50);
  twice = {};
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  run(50);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_EQ(rig->master.duplicate_slaves().bits, 0u);
  EXPECT_EQ(enter_run(), Refusal::none);
}

TEST_F(WhoIsThere, WhereTwoDrivesAreReportedAloneTheLineRuns) {
  settings.startup.on_duplicate = OnDuplicate::report;
  twice.set(slave(1));
  set_up();
  run(50);
  EXPECT_EQ(times(Code::duplicate_slave), 1u);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_EQ(enter_run(), Refusal::none);
}

TEST_F(WhoIsThere, SlowAnswersAreNotTakenForThoseOfASecondDrive) {
  set_up();
  run(30);
  std::vector<Telegram> late;
  rig->answer = [&](const Telegram& t) -> std::optional<Telegram> {
    if (const auto* command = std::get_if<ParameterCommand>(&t); command != nullptr) {
      late.push_back(MasterRig::word_reply(*command, 0x8007));
    }
    return std::nullopt;
  };
  // Each answer comes after the next question.
  for (unsigned i = 0; i < 2000; ++i) {
    rig->step();
    if (late.size() < 2) continue;
    rig->master.receive(encode(late.front()), std::chrono::microseconds(800));
    late.erase(late.begin());
  }
  EXPECT_EQ(times(Code::duplicate_slave), 0u);
}

TEST_F(WhoIsThere, AnswersToAnotherMasterSayNothing) {
  set_up();
  run(30);
  ParameterCommand foreign;
  foreign.slave = slave(1);
  foreign.number = parameter(301);
  for (unsigned i = 0; i < 100; ++i) {
    step();
    rig->master.receive(encode(Telegram{foreign}), std::chrono::microseconds(700));
    rig->master.receive(encode(MasterRig::word_reply(foreign, 0x8007)), std::chrono::microseconds(900));
  }
  EXPECT_EQ(times(Code::second_master), 1u);
  EXPECT_EQ(times(Code::duplicate_slave), 0u);
}

TEST_F(WhoIsThere, EachNumberThatIsNotConfiguredIsAskedOnceAndWhoAnswersIsNamed) {
  settings.startup.census = true;
  settings.startup.status_period = std::chrono::seconds(0);
  present.set(slave(9));
  present.set(slave(31));
  set_up();
  run(100);
  std::multiset<unsigned> foreign;
  for (const SlaveNumber one : asked) {
    if (one.value() > 2) foreign.insert(one.value());
  }
  EXPECT_EQ(foreign.size(), 29u);
  EXPECT_EQ(std::set<unsigned>(foreign.begin(), foreign.end()).size(), 29u) << "each once";
  EXPECT_EQ(times(Code::unknown_slave), 2u);
  EXPECT_EQ(rig->master.unknown_slaves().bits, (1u << 9) | (1u << 31));
  EXPECT_EQ(rig->told.statuses.count(9), 0u) << "it is no slave of the line";
  EXPECT_EQ(enter_run(), Refusal::none) << "it is named, and keeps nobody waiting";
}

TEST_F(WhoIsThere, TheCensusDelaysEachSlaveOfTheLineByOneIntervalAtMost) {
  locks = 20;
  const auto intervals_to_run = [&](bool census) {
    settings.startup.census = census;
    set_up();
    unsigned n = 0;
    for (; enter_run() != Refusal::none; ++n) step();
    return n;
  };
  const unsigned without = intervals_to_run(false);
  EXPECT_LE(intervals_to_run(true), without + 3);
}

TEST_F(WhoIsThere, TheCensusGoesOnWhileADriveIsWaitedFor) {
  settings.startup.census = true;
  present.set(slave(2), false);
  present.set(slave(20));
  set_up();
  run(120);
  EXPECT_EQ(times(Code::unknown_slave), 1u);
}

TEST_F(WhoIsThere, AJobComesBeforeTheCensus) {
  settings.startup.census = true;
  set_up();
  run(8);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(0), .number = parameter(10)}),
            Refusal::none);
  step();
  step();
  EXPECT_EQ(rig->told.terminal, 1u);
}

TEST_F(WhoIsThere, NoNumberIsAskedWithoutTheCensus) {
  present.set(slave(9));
  set_up();
  run(100);
  EXPECT_TRUE(std::all_of(asked.begin(), asked.end(), [](SlaveNumber one) { return one.value() < 3; }));
  EXPECT_EQ(times(Code::unknown_slave), 0u);
}

TEST(AnswerBalances, KeepsACommandAndActualValuesApart) {
  AnswerBalance balance;
  balance.asked(0, slave(1), 5, false);
  EXPECT_FALSE(balance.answered(2, slave(1), 5, true));
  EXPECT_FALSE(balance.answered(0, slave(2), 5, true));
  EXPECT_TRUE(balance.answered(0, slave(1), 5, true));
  EXPECT_FALSE(balance.answered(0, slave(1), 5, true));
  EXPECT_TRUE(balance.answered(0, slave(1), 5, false)) << "an answer to something else is no second one";
}

TEST(AnswerBalances, OwesOneAnswerToASlaveThatIsAway) {
  AnswerBalance balance;
  for (unsigned i = 0; i < 3; ++i) balance.asked(2, slave(1), 5, false);
  for (unsigned i = 0; i < 3; ++i) balance.asked(2, slave(1), 5, true);
  EXPECT_TRUE(balance.answered(2, slave(1), 5, true));
  EXPECT_TRUE(balance.answered(2, slave(1), 5, true)) << "that to the question before came late";
  EXPECT_FALSE(balance.answered(2, slave(1), 5, true));
}

TEST(AnswerBalances, WhatWasNotAnsweredForLongHidesNoSecondDrive) {
  AnswerBalance balance;
  for (IntervalNumber n = 1; n < 4; ++n) balance.asked(2, slave(1), n, false);
  EXPECT_TRUE(balance.answered(2, slave(1), 4, true));
  EXPECT_TRUE(balance.answered(2, slave(1), 4, true)) << "late";
  balance.asked(2, slave(1), 20, false);
  EXPECT_TRUE(balance.answered(2, slave(1), 20, true));
  EXPECT_FALSE(balance.answered(2, slave(1), 20, true));
}

}  // namespace
}  // namespace cansync::test
