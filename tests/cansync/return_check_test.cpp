// Slaves that come back: held out until they are synchronized and have passed their list of parameters.
#include <algorithm>
#include <map>

#include "master_rig.h"

namespace cansync::test {
namespace {

using Code = MasterEvent::Code;

/// Four drives with a memory of parameters. Number 20 is a doubleword, 30 is read only, 40 is never done.
struct Drives {
  SlaveMask dead;
  SlaveMask unsynchronized;
  std::map<std::pair<unsigned, unsigned>, std::uint32_t> values;  // by slave and number
  std::vector<ParameterCommand> asked;                            // but status words
  SlaveMask busy;                                                 // with number 40
  unsigned disturbed = 0;  // commands that a busy one took for another job

  std::optional<Telegram> operator()(const Telegram& telegram) {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr || dead.has(command->slave)) return std::nullopt;
    const unsigned number = command->number.value();
    disturbed += busy.has(command->slave) && number != 40 ? 1 : 0;
    busy.set(command->slave, number == 40);
    if (number == 301) {
      return MasterRig::word_reply(*command, unsynchronized.has(command->slave) ? 0x0007 : 0x8007);
    }
    asked.push_back(*command);
    if (number == 40) return MasterRig::busy_reply(*command);
    std::uint32_t& value = values[{command->slave.value(), number}];
    if (command->kind == ParameterCommand::Kind::read) {
      return number == 20 ? MasterRig::doubleword_reply(*command, value)
                          : MasterRig::word_reply(*command, static_cast<std::uint16_t>(value));
    }
    if (number == 30) return MasterRig::error_reply(*command, ParameterError::not_changeable);
    value = command->value;
    return MasterRig::written_reply(*command);
  }
};

struct Returns : testing::Test {
  MasterSettings settings = settings_for(4);
  std::shared_ptr<Drives> drives = std::make_shared<Drives>();
  std::unique_ptr<MasterRig> rig;

  void wants(unsigned n, OnReturn what, const std::vector<std::pair<unsigned, std::uint32_t>>& list) {
    SlaveSettings& one = settings.slaves[n];
    one.on_return = what;
    for (const auto& [number, value] : list) {
      one.return_parameters[one.return_count++] = {parameter(number), value};
    }
  }
  void start() {
    settings.startup.status_period = std::chrono::milliseconds(20);
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [drives = drives](const Telegram& t) { return (*drives)(t); };
    rig->activate();
  }
  SlaveState state(unsigned n) const { return rig->master.slave(slave(n)).state; }
  void lose(unsigned n) {
    drives->dead.set(slave(n));
    rig->run_until([=, this] { return state(n) == SlaveState::lost; }, 200);
  }
  void bring_back(unsigned n) {
    drives->dead.set(slave(n), false);
    rig->told.events.clear();
    drives->asked.clear();
    rig->run_until([=, this] { return rig->master.slave(slave(n)).responds; }, 100);
  }
  void run_to(unsigned n, SlaveState wanted) {
    rig->run_until([=, this] { return state(n) == wanted; }, 500);
  }
  /// The events of one slave since it came back.
  std::vector<Code> steps(unsigned n) const {
    std::vector<Code> codes;
    for (const MasterEvent& event : rig->told.events) {
      if (event.slave == slave(n)) codes.push_back(event.code);
    }
    return codes;
  }
  Refusal control(JobId id, unsigned n, std::uint16_t word) {
    return rig->master.submit(ControlWordRequest{id, slave(n), word});
  }
};

TEST_F(Returns, AtTheStartASlaveIsReleasedAsSoonAsItIsSynchronized) {
  wants(1, OnReturn::check, {{10, 5}});
  drives->unsynchronized = SlaveMask::all();
  rig = std::make_unique<MasterRig>(settings);
  rig->answer = [this](const Telegram& t) { return (*drives)(t); };
  rig->set_up();
  EXPECT_EQ(state(1), SlaveState::absent);
  rig->run(10);
  EXPECT_EQ(state(1), SlaveState::starting);
  drives->unsynchronized = {};
  rig->run(10);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_TRUE(drives->asked.empty()) << "the list is for those that were away";
}

TEST_F(Returns, IsHeldOutUntilItIsSynchronizedAgain) {
  start();
  lose(1);
  drives->unsynchronized.set(slave(1));
  bring_back(1);
  EXPECT_EQ(state(1), SlaveState::returning);
  rig->run(300);
  EXPECT_EQ(state(1), SlaveState::returning);
  EXPECT_EQ(rig->master.slave(slave(0)).state, SlaveState::released);
  drives->unsynchronized = {};
  run_to(1, SlaveState::released);
  EXPECT_EQ(steps(1), (std::vector{Code::slave_returned, Code::slave_synchronized, Code::slave_released}));
}

TEST_F(Returns, EnablingControlWordsAreRefusedWhileItIsHeldOutAndOthersAreNot) {
  start();
  lose(1);
  drives->unsynchronized.set(slave(1));
  bring_back(1);
  EXPECT_EQ(control(1, 1, 0x000F), Refusal::slave_held);
  EXPECT_EQ(control(10, 1, 0xFFFF), Refusal::slave_held) << "whatever the other bits are";
  constexpr std::uint16_t kStopping[] = {0x00, 0x02, 0x06, 0x07, 0x0B};
  for (const std::uint16_t stop : kStopping) {
    EXPECT_EQ(control(20u + stop, 1, stop), Refusal::none) << stop;
    rig->step();
  }
  EXPECT_EQ(control(3, 0, 0x000F), Refusal::none) << "another slave";
  const BroadcastRequest all{4, 1, {SlaveMask{0xF}, kCommandControlWord, 0, 0x000F}};
  EXPECT_EQ(rig->master.submit(BroadcastRequest{8, 0, {SlaveMask{0xF}, kCommandControlWord, 0, 0x0002}}),
            Refusal::none)
      << "a quick stop of the whole line";
  EXPECT_EQ(rig->master.submit(all), Refusal::slave_held);
  EXPECT_EQ(rig->master.submit(BroadcastRequest{5, 1, {SlaveMask{0xD}, kCommandControlWord, 0, 0x000F}}),
            Refusal::none);
  EXPECT_EQ(rig->master.submit(BroadcastRequest{6, 1, {SlaveMask{0xF}, 200, 0, 0x000F}}), Refusal::none);
  rig->run(10);
  for (const JobId id : {8u, 20u, 22u, 26u, 27u, 31u}) EXPECT_EQ(rig->told.commands.at(id), Outcome::done);
  drives->unsynchronized = {};
  run_to(1, SlaveState::released);
  EXPECT_EQ(control(7, 1, 0x000F), Refusal::none);
  EXPECT_EQ(rig->master.submit(all), Refusal::none);
}

TEST_F(Returns, AnEnablingControlWordThatWaitsWhenTheSlaveLosesSyncIsNotSent) {
  start();
  const Cursor nobody{Cursor::Kind::nobody, {}};
  const Cursor automatic;
  ASSERT_EQ(rig->master.set_command_cursors(nobody, automatic, automatic), Refusal::none);
  ASSERT_EQ(control(1, 1, 0x000F), Refusal::none);
  ASSERT_EQ(control(2, 0, 0x000F), Refusal::none);
  drives->unsynchronized.set(slave(1));
  run_to(1, SlaveState::returning);
  ASSERT_EQ(rig->master.set_command_cursors(automatic, automatic, automatic), Refusal::none);
  rig->run_until([this] { return rig->told.commands.contains(1) && rig->told.commands.contains(2); }, 10);
  EXPECT_EQ(rig->told.commands.at(1), Outcome::slave_held);
  EXPECT_EQ(rig->told.commands.at(2), Outcome::done);
}

TEST_F(Returns, ParametersAndTransfersAreServedWhileItIsHeldOut) {
  start();
  lose(1);
  drives->unsynchronized.set(slave(1));
  bring_back(1);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(1), .number = parameter(10)}),
            Refusal::none);
  rig->run_until([this] { return rig->told.terminal == 1; }, 20);
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::done);
}

TEST_F(Returns, ChecksItsListAndIsReleasedWhenAllIsRight) {
  wants(1, OnReturn::check, {{10, 5}, {20, 0x12345678}});
  start();
  lose(1);
  drives->values = {{{1, 10}, 5}, {{1, 20}, 0x12345678}};
  bring_back(1);
  run_to(1, SlaveState::released);
  EXPECT_EQ(steps(1), (std::vector{Code::slave_returned, Code::slave_synchronized, Code::slave_checked,
                                   Code::slave_released}));
  ASSERT_EQ(drives->asked.size(), 2u);
  for (const ParameterCommand& asked : drives->asked) EXPECT_EQ(asked.kind, ParameterCommand::Kind::read);
}

TEST_F(Returns, AWrongValueHoldsItOutAndSaysWhichIsExpectedAndWhichWasFound) {
  wants(1, OnReturn::check, {{10, 5}, {20, 1000}, {11, 1}});
  start();
  lose(1);
  drives->values = {{{1, 10}, 5}, {{1, 20}, 999}};
  bring_back(1);
  run_to(1, SlaveState::held);
  const MasterEvent failed = rig->told.events.back();
  EXPECT_EQ(failed.code, Code::slave_check_failed);
  EXPECT_EQ(failed.slave, slave(1));
  EXPECT_EQ(failed.detail, 20u);
  EXPECT_EQ(failed.expected, 1000u);
  EXPECT_EQ(failed.found, 999u);
  EXPECT_EQ(failed.outcome, Outcome::done);
  EXPECT_EQ(control(1, 1, 0x000F), Refusal::slave_held);
  rig->run(200);
  EXPECT_EQ(state(1), SlaveState::held) << "until somebody does something about it";
  EXPECT_EQ(rig->master.control(ControlCommand::start_synchronous), Refusal::none);
  EXPECT_EQ(rig->master.control(ControlCommand::enable_active), Refusal::slaves_missing);
  // The operator sets it right and releases it: the list is gone through once more.
  drives->values = {{{1, 10}, 5}, {{1, 20}, 1000}, {{1, 11}, 1}};
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  run_to(1, SlaveState::released);
  EXPECT_EQ(rig->master.control(ControlCommand::enable_active), Refusal::none);
}

TEST_F(Returns, WritesItsListInTheSlavesFormatAndReadsItBack) {
  wants(1, OnReturn::write, {{20, 0x12345678}, {10, 5}});
  start();
  lose(1);
  bring_back(1);
  run_to(1, SlaveState::released);
  EXPECT_EQ(drives->values.at({1, 20}), 0x12345678u);
  EXPECT_EQ(drives->values.at({1, 10}), 5u);
  using Kind = ParameterCommand::Kind;
  const std::vector<std::pair<unsigned, Kind>> expected = {
      {20, Kind::read}, {20, Kind::write_doubleword}, {20, Kind::read},
      {10, Kind::read}, {10, Kind::write_word},       {10, Kind::read}};
  ASSERT_EQ(drives->asked.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(std::pair(unsigned{drives->asked[i].number.value()}, drives->asked[i].kind), expected[i]) << i;
  }
}

TEST_F(Returns, ARefusedOrEndlessWriteHoldsItOutWithTheReason) {
  wants(1, OnReturn::write, {{30, 1}});
  wants(2, OnReturn::write, {{10, 0x10000}});
  wants(3, OnReturn::write, {{40, 1}});
  settings.command_channel.parameter_monitoring = std::chrono::milliseconds(30);
  start();
  for (const unsigned n : {1u, 2u, 3u}) {
    lose(n);
    bring_back(n);
    run_to(n, SlaveState::held);
    const MasterEvent failed = rig->told.events.back();
    ASSERT_EQ(failed.code, Code::slave_check_failed);
    if (n == 1) {
      EXPECT_EQ(failed.outcome, Outcome::slave_error);
      EXPECT_EQ(failed.found, 0xFFFCu);
    }
    if (n == 2) {
      EXPECT_EQ(failed.outcome, Outcome::value_too_wide);
    }
    if (n == 3) {
      EXPECT_EQ(failed.outcome, Outcome::timeout);
    }
  }
}

// Another parameter command is another job (M 3.2.3.7, "change"): asked again, the slave would begin the
// write anew.
TEST_F(Returns, ASlaveThatIsBusyWithAWriteOfItsListIsLeftAlone) {
  wants(1, OnReturn::write, {{40, 5}});
  settings.command_channel.parameter_monitoring = std::chrono::milliseconds(500);
  start();
  lose(1);
  bring_back(1);
  rig->run_until([this] { return drives->busy.has(slave(1)); }, 500);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 7, .slave = slave(1), .number = parameter(10)}),
            Refusal::none);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 8, .slave = slave(0), .number = parameter(10)}),
            Refusal::none);
  rig->run(100);
  EXPECT_EQ(state(1), SlaveState::checking);
  EXPECT_EQ(drives->disturbed, 0u);
  EXPECT_TRUE(rig->told.parameters.contains(8)) << "another slave's are served";
  EXPECT_FALSE(rig->told.parameters.contains(7));
  run_to(1, SlaveState::held);
  rig->run_until([this] { return rig->told.parameters.contains(7); }, 1000);
  EXPECT_EQ(rig->told.parameters.at(7).outcome, Outcome::done) << "as soon as the write has run out of time";
}

TEST_F(Returns, AnUnansweredTelegramOfTheListIsSentAgainAndSilenceMakesItLostAgain) {
  wants(1, OnReturn::write, {{20, 7}});
  start();
  lose(1);
  bring_back(1);
  run_to(1, SlaveState::checking);
  drives->dead.set(slave(1));
  rig->run(2);
  drives->dead = {};
  run_to(1, SlaveState::released);
  EXPECT_EQ(drives->values.at({1, 20}), 7u);
  lose(1);
  bring_back(1);
  run_to(1, SlaveState::checking);
  lose(1);
  bring_back(1);
  run_to(1, SlaveState::released);
  EXPECT_EQ(rig->master.slave(slave(1)).times_lost, 3u);
  EXPECT_EQ(rig->master.slave(slave(1)).times_returned, 3u);
}

TEST_F(Returns, ALongListLeavesTheJobsOfClientsTheirIntervalsAndIsNotStarvedByThem) {
  std::vector<std::pair<unsigned, std::uint32_t>> list;
  for (unsigned i = 0; i < kListedParameters; ++i) list.emplace_back(100 + i, 0);
  wants(1, OnReturn::check, list);
  settings.command_channel.minimum_share = 8;
  start();
  lose(1);
  bring_back(1);
  run_to(1, SlaveState::checking);
  drives->asked.clear();
  unsigned jobs = 0;
  JobId id = 0;
  const unsigned intervals = rig->run_until(
      [&] {
        while (jobs - rig->told.parameters.size() < 5) {
          EXPECT_EQ(
              rig->master.submit(ParameterRequest{.id = ++id, .slave = slave(0), .number = parameter(10)}),
              Refusal::none);
          ++jobs;
        }
        return state(1) == SlaveState::released;
      },
      1000);
  EXPECT_LE(intervals, (kListedParameters + 2) * 8);
  EXPECT_GE(rig->told.parameters.size(), intervals * 3 / 4);
}

TEST_F(Returns, ASlaveThatLosesSyncWithoutGoingAwayPassesItsListToo) {
  wants(1, OnReturn::check, {{10, 5}});
  start();
  drives->values = {{{1, 10}, 5}};
  drives->unsynchronized.set(slave(1));
  run_to(1, SlaveState::returning);
  drives->unsynchronized = {};
  run_to(1, SlaveState::released);
  EXPECT_EQ(drives->asked.size(), 1u);
  EXPECT_EQ(rig->master.slave(slave(1)).times_lost, 0u);
}

TEST_F(Returns, ReleaseByHand) {
  wants(1, OnReturn::check, {{10, 5}});
  start();
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::not_held);
  EXPECT_EQ(rig->master.release(slave(9), true), Refusal::slave_not_configured);
  lose(1);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::slave_lost);
  bring_back(1);
  run_to(1, SlaveState::held);
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  EXPECT_EQ(state(1), SlaveState::checking);
  run_to(1, SlaveState::held);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_EQ(rig->told.events.back().code, Code::slave_released);
  EXPECT_EQ(rig->told.events.back().detail, 1u);
  // One that is not synchronized is activated again instead.
  drives->unsynchronized.set(slave(1));
  run_to(1, SlaveState::returning);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  EXPECT_EQ(state(1), SlaveState::returning);
  rig->step();
  ASSERT_NE(rig->command(), nullptr);
  EXPECT_EQ(*rig->command(), Telegram(ActionCommand{SlaveMask::of(slave(1)), 2, 1, 0}));
}

/// With a command of the list of slave 1 on the bus, whose answer comes with the next interval.
struct AskedForTheList : Returns {
  void ask_for(OnReturn what) {
    wants(1, what, {{10, 5}, {11, 6}});
    drives->values[{1, 10}] = 5;
    start();
    lose(1);
    bring_back(1);
    rig->run_until([this] { return !drives->asked.empty(); }, 500);
    ASSERT_EQ(state(1), SlaveState::checking);
  }
};

TEST_F(AskedForTheList, ReleasedByForceItsAnswerSaysNothingButThatTheSlaveIsThere) {
  for (const OnReturn what : {OnReturn::check, OnReturn::write}) {
    drives = std::make_shared<Drives>();
    settings = settings_for(4);
    ask_for(what);
    const auto unanswered = rig->master.slave(slave(1)).unanswered;
    EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
    rig->run(3);
    EXPECT_EQ(state(1), SlaveState::released);
    EXPECT_EQ(drives->asked.size(), 1u) << "the rest of the list is not for a released slave";
    EXPECT_EQ(rig->master.slave(slave(1)).unanswered, unanswered);
  }
}

TEST_F(AskedForTheList, AnswersFromBeforeTheBusWasLostSayNothing) {
  ask_for(OnReturn::check);
  rig->master.bus_lost();
  rig->step();
  EXPECT_NE(state(1), SlaveState::released);
  EXPECT_NE(state(1), SlaveState::held);
}

TEST_F(AskedForTheList, BegunAnewTheConfirmationOfTheOldWriteIsNoAnswerToTheNewRead) {
  wants(1, OnReturn::write, {{20, 70000}});  // a doubleword
  start();
  lose(1);
  bring_back(1);
  const auto writes = [this] {
    return !drives->asked.empty() && drives->asked.back().kind == ParameterCommand::Kind::write_doubleword;
  };
  rig->run_until(writes, 500);
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  run_to(1, SlaveState::released);
  for (const ParameterCommand& command : drives->asked) {
    const bool word = command.kind == ParameterCommand::Kind::write_word;
    EXPECT_FALSE(word && command.number.value() == 20);
  }
  EXPECT_EQ((drives->values[{1, 20}]), 70000u);
}

}  // namespace
}  // namespace cansync::test
