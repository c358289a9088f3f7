// Who a slave is: what it must say of itself before it is activated, enabled, or counts for run.
#include <algorithm>
#include <map>

#include "master_rig.h"

namespace cansync::test {
namespace {

using Code = MasterEvent::Code;

constexpr unsigned kType = 100;    // a word
constexpr unsigned kSerial = 102;  // a doubleword

/// Drives with a type and a serial number each. One that is activated synchronizes.
struct Drives {
  SlaveMask dead;
  SlaveMask activated;
  SlaveMask busy;      // with what tells who they are
  SlaveMask refusing;  // it
  SlaveMask never_synchronized;
  std::map<unsigned, std::uint32_t> type;
  std::map<unsigned, std::uint32_t> serial;
  unsigned asked_who = 0;

  std::optional<Telegram> operator()(const Telegram& telegram) {
    if (const auto* action = std::get_if<ActionCommand>(&telegram)) {
      if (action->command != kCommandControlWord) activated.bits |= action->slaves.bits;
      return std::nullopt;
    }
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr || dead.has(command->slave)) return std::nullopt;
    const unsigned n = command->slave.value();
    const unsigned number = command->number.value();
    const bool synchronized = activated.has(command->slave) && !never_synchronized.has(command->slave);
    if (number == 301) return MasterRig::word_reply(*command, synchronized ? 0x8007 : 7);
    ++asked_who;
    if (busy.has(command->slave)) return MasterRig::busy_reply(*command);
    if (refusing.has(command->slave))
      return MasterRig::error_reply(*command, ParameterError::not_available_now);
    return number == kSerial ? MasterRig::doubleword_reply(*command, serial[n])
                             : MasterRig::word_reply(*command, static_cast<std::uint16_t>(type[n]));
  }
};

/// Three drives of type 4400 with serial numbers 1000, 1001, 1002, of which 0 and 1 are expected.
struct Identity : testing::Test {
  MasterSettings settings = settings_for(3);
  std::shared_ptr<Drives> drives = std::make_shared<Drives>();
  std::unique_ptr<MasterRig> rig;

  Identity() {
    settings.startup.status_period = std::chrono::milliseconds(20);
    for (unsigned n = 0; n < 3; ++n) {
      drives->type[n] = 4400;
      drives->serial[n] = 1000 + n;
    }
    for (unsigned n = 0; n < 2; ++n) expect(n, {{kType, 4400}, {kSerial, 1000 + n}});
  }
  void expect(unsigned n, const std::vector<std::pair<unsigned, std::uint32_t>>& list) {
    SlaveSettings& one = settings.slaves[n];
    one.expect_count = 0;
    for (const auto& [number, value] : list) one.expect[one.expect_count++] = {parameter(number), value};
  }
  void set_up() {
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [drives = drives](const Telegram& t) { return (*drives)(t); };
    rig->set_up();
  }
  void set_up_and_wait() {
    set_up();
    rig->run(100);
  }
  void exchange(unsigned one, unsigned other) { std::swap(drives->serial[one], drives->serial[other]); }
  const SlaveStatus& status(unsigned n) const { return rig->master.slave(slave(n)); }
  SlaveState state(unsigned n) const { return status(n).state; }
  Refusal run() { return rig->master.control(ControlCommand::enable_active); }
  Refusal enable(JobId id, unsigned n) {
    return rig->master.submit(ControlWordRequest{id, slave(n), 0x000F});
  }
  void lose(unsigned n) {
    drives->dead.set(slave(n));
    rig->run_until([=, this] { return state(n) == SlaveState::lost; }, 200);
    drives->activated.set(slave(n), false);
  }
  void bring_back(unsigned n) {
    drives->dead.set(slave(n), false);
    rig->told.events.clear();
    rig->run(100);
  }
  std::vector<Code> steps(unsigned n) const {
    std::vector<Code> codes;
    for (const MasterEvent& event : rig->told.events) {
      if (event.slave == slave(n)) codes.push_back(event.code);
    }
    return codes;
  }
};

TEST_F(Identity, TheDrivesExpectedAreReleasedAndRunIsEntered) {
  set_up_and_wait();
  EXPECT_EQ(steps(0), (std::vector{Code::slave_responds, Code::slave_identified, Code::slave_synchronized}));
  EXPECT_EQ(steps(2), (std::vector{Code::slave_responds, Code::slave_synchronized})) << "any drive is right";
  for (unsigned n = 0; n < 3; ++n) EXPECT_EQ(state(n), SlaveState::released) << n;
  EXPECT_EQ(drives->asked_who, 4u) << "each parameter once";
  EXPECT_EQ(run(), Refusal::none);
}

TEST_F(Identity, AsksWithinTheTimeThatDrivesNeedToSynchronize) {
  set_up();
  const unsigned intervals = rig->run_until([this] { return state(0) == SlaveState::released; }, 100);
  // An activation, three status words, twice two parameters, an activation of each and a status word again.
  EXPECT_LE(intervals, 20u);
}

TEST_F(Identity, AnExchangedPairIsHeldNotActivatedAndKeptFromRun) {
  exchange(0, 1);
  set_up_and_wait();
  for (const unsigned n : {0u, 1u}) {
    EXPECT_EQ(state(n), SlaveState::held);
    EXPECT_FALSE(drives->activated.has(slave(n))) << "it must not take reference values";
    EXPECT_EQ(enable(10 + n, n), Refusal::slave_held);
    ASSERT_TRUE(status(n).held);
    const MasterEvent expected{Code::wrong_drive, slave(n), kSerial, 1000 + n, 1001 - n, Outcome::done};
    EXPECT_EQ(*status(n).held, expected);
    EXPECT_EQ(steps(n), (std::vector{Code::slave_responds, Code::wrong_drive})) << "said once";
  }
  EXPECT_EQ(state(2), SlaveState::released);
  EXPECT_EQ(run(), Refusal::slaves_missing);
}

TEST_F(Identity, NoRuleOfEnablingLetsAWrongDriveIntoRun) {
  for (const EnableRule rule : {EnableRule::all_synchronized, EnableRule::all_responding, EnableRule::any}) {
    settings.startup.enable = rule;
    drives->serial[1] = 7;
    set_up();
    for (unsigned i = 0; i < 100; ++i) {
      ASSERT_EQ(run(), Refusal::slaves_missing) << static_cast<int>(rule) << " in interval " << i;
      rig->step();
    }
    EXPECT_EQ(rig->master.control(ControlCommand::enable_active, true), Refusal::none) << "by force";
    rig->run(100);
    EXPECT_EQ(state(1), SlaveState::held);
    EXPECT_FALSE(drives->activated.has(slave(1)));
    EXPECT_EQ(enable(1, 1), Refusal::slave_held);
  }
}

TEST_F(Identity, AnAbsentDriveDoesNotKeepTheRuleAnyWaiting) {
  settings.startup.enable = EnableRule::any;
  drives->dead.set(slave(1));
  set_up();
  rig->run_until([this] { return run() == Refusal::none; }, 100);
  EXPECT_EQ(enable(1, 1), Refusal::slave_held) << "nobody knows who will come";
}

TEST_F(Identity, ALateDriveIsAskedInRunBeforeItIsActivated) {
  settings.startup.enable = EnableRule::any;
  drives->dead.set(slave(0));
  drives->dead.set(slave(1));
  drives->serial[1] = 7;
  set_up_and_wait();
  ASSERT_EQ(run(), Refusal::none);
  rig->run(100);
  drives->dead = {};
  rig->told.events.clear();
  rig->run(100);
  EXPECT_EQ(state(0), SlaveState::released);
  EXPECT_EQ(enable(1, 0), Refusal::none);
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(enable(2, 1), Refusal::slave_held);
  const BroadcastRequest all{3, 0, {SlaveMask{0x7}, kCommandControlWord, 0, 0x000F}};
  EXPECT_EQ(rig->master.submit(all), Refusal::slave_held);
}

TEST_F(Identity, ADriveReplacedWhileItWasAwayIsHeldAndTheSameOneIsReleased) {
  set_up_and_wait();
  ASSERT_EQ(run(), Refusal::none);
  lose(0);
  lose(1);
  drives->serial[1] = 2001;
  bring_back(0);
  bring_back(1);
  EXPECT_EQ(state(0), SlaveState::released);
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(steps(1), (std::vector{Code::slave_returned, Code::wrong_drive}));
  EXPECT_EQ(enable(1, 1), Refusal::slave_held);
}

TEST_F(Identity, ADriveExchangedBetweenTwoStatusWordsIsFoundByItsLossOfSync) {
  set_up_and_wait();
  ASSERT_EQ(run(), Refusal::none);
  drives->activated.set(slave(1), false);
  drives->serial[1] = 2001;
  rig->run(100);
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_FALSE(drives->activated.has(slave(1)));
}

TEST_F(Identity, ADriveIsAskedAgainWhoItIsBeforeItIsActivatedAgain) {
  drives->never_synchronized.set(slave(1));
  set_up_and_wait();
  ASSERT_TRUE(drives->activated.has(slave(1)));
  drives->activated.set(slave(1), false);
  rig->told.events.clear();
  rig->run(5000);
  EXPECT_TRUE(drives->activated.has(slave(1)));
  EXPECT_EQ(rig->told.count(Code::slave_identified), 0u) << "nothing new";
  // Exchanged so quickly that no answer is missing: nothing tells it.
  drives->activated.set(slave(1), false);
  drives->serial[1] = 2001;
  rig->run(5000);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(steps(1), std::vector{Code::wrong_drive});
}

TEST_F(Identity, ByForceADriveIsActivatedAgainUnasked) {
  drives->never_synchronized.set(slave(1));
  drives->serial[1] = 2001;
  set_up_and_wait();
  ASSERT_EQ(rig->master.release(slave(1), true), Refusal::none);
  rig->run(100);
  ASSERT_TRUE(drives->activated.has(slave(1)));
  drives->activated.set(slave(1), false);
  rig->run(5000);
  EXPECT_TRUE(drives->activated.has(slave(1)));
}

TEST_F(Identity, TwoDrivesOfANumberAreNotActivated) {
  settings.startup.enable = EnableRule::any;
  set_up();
  rig->second_answer = [](const ParameterCommand& command) -> std::optional<Telegram> {
    if (command.slave != slave(1)) return std::nullopt;
    return MasterRig::word_reply(command, 7);
  };
  rig->run(100);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_TRUE(drives->activated.has(slave(0)));
}

TEST_F(Identity, TheOneOfTwoDrivesThatIsLeftIsAskedAgain) {
  bool two = true;
  set_up();
  rig->second_answer = [&](const ParameterCommand& command) -> std::optional<Telegram> {
    if (command.slave != slave(1) || !two) return std::nullopt;
    return MasterRig::word_reply(command, 7);
  };
  rig->run_until([this] { return rig->told.count(Code::slave_identified) == 1; }, 100);
  rig->run(2);
  ASSERT_EQ(rig->told.count(Code::slave_identified), 1u) << "not yet of the two";
  ASSERT_EQ(rig->told.count(Code::duplicate_slave), 0u);
  two = false;
  drives->serial[1] = 2001;
  EXPECT_EQ(enable(7, 1), Refusal::slave_held);
  rig->run(100);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(state(1), SlaveState::held);
}

TEST_F(Identity, TwoDrivesOfANumberThatComeTogetherInRunAreNotActivated) {
  settings.startup.enable = EnableRule::any;
  drives->dead.set(slave(1));
  set_up_and_wait();
  ASSERT_EQ(run(), Refusal::none);
  rig->run(100);
  drives->dead = {};
  rig->second_answer = [](const ParameterCommand& command) -> std::optional<Telegram> {
    if (command.slave != slave(1)) return std::nullopt;
    return MasterRig::word_reply(command, 7);
  };
  rig->run(1500);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(rig->told.count(Code::duplicate_slave), 1u);
}

TEST_F(Identity, WhoTheDriveIsComesBeforeItsListOfParameters) {
  SlaveSettings& one = settings.slaves[1];
  one.on_return = OnReturn::write;
  one.return_parameters[one.return_count++] = {parameter(kType), 4400};
  set_up_and_wait();
  lose(1);
  drives->serial[1] = 2001;
  bring_back(1);
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(status(1).held->code, Code::wrong_drive);
}

TEST_F(Identity, ADriveThatRefusesWhatTellsWhoItIsIsNotTheOneExpected) {
  drives->refusing.set(slave(1));
  set_up_and_wait();
  EXPECT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(status(1).held->detail, kType);
  EXPECT_EQ(status(1).held->outcome, Outcome::slave_error);
  EXPECT_EQ(status(1).held->found, static_cast<std::uint32_t>(ParameterError::not_available_now));
}

TEST_F(Identity, ADriveThatIsBusyIsAskedAgainAndHeldWhenItStaysBusy) {
  drives->busy.set(slave(1));
  set_up_and_wait();
  EXPECT_EQ(state(1), SlaveState::starting);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(run(), Refusal::slaves_missing);
  drives->busy = {};
  rig->run(100);
  EXPECT_EQ(state(1), SlaveState::released);
  lose(1);
  drives->busy.set(slave(1));
  bring_back(1);
  rig->run_until([this] { return state(1) == SlaveState::held; }, 5000);
  EXPECT_EQ(status(1).held->outcome, Outcome::timeout);
}

TEST_F(Identity, ReleaseReadsAgain) {
  exchange(0, 1);
  set_up_and_wait();
  rig->told.events.clear();
  EXPECT_EQ(rig->master.release(slave(0), false), Refusal::none);
  rig->run(100);
  EXPECT_EQ(state(0), SlaveState::held) << "still the other one";
  EXPECT_EQ(steps(0), (std::vector{Code::wrong_drive}));
  exchange(0, 1);
  EXPECT_EQ(rig->master.release(slave(0), false), Refusal::none);
  rig->run(100);
  EXPECT_EQ(state(0), SlaveState::released);
  EXPECT_FALSE(status(0).held);
}

TEST_F(Identity, AReleaseAsksADriveThatIsNotSynchronizedAgain) {
  drives->never_synchronized.set(slave(1));
  set_up_and_wait();
  lose(1);
  bring_back(1);
  ASSERT_EQ(state(1), SlaveState::returning);
  ASSERT_TRUE(drives->activated.has(slave(1)));
  drives->activated.set(slave(1), false);
  drives->serial[1] = 2001;
  EXPECT_EQ(rig->master.release(slave(1), false), Refusal::none);
  rig->run(100);
  EXPECT_FALSE(drives->activated.has(slave(1)));
  EXPECT_EQ(state(1), SlaveState::held);
}

TEST_F(Identity, ForceTakesTheDriveThatIsThereUntilItIsLost) {
  drives->serial[1] = 2001;
  set_up_and_wait();
  ASSERT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  rig->run(100);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_TRUE(drives->activated.has(slave(1)));
  EXPECT_EQ(run(), Refusal::none);
  lose(1);
  bring_back(1);
  EXPECT_EQ(state(1), SlaveState::held);
  drives->activated.set(slave(1));  // still synchronized: a short interruption
  rig->run(100);
  ASSERT_EQ(state(1), SlaveState::held);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  EXPECT_EQ(state(1), SlaveState::released);
}

TEST_F(Identity, ForceWhileADriveIsAskedEndsTheQuestion) {
  drives->busy.set(slave(1));
  drives->serial[1] = 2001;
  set_up_and_wait();
  ASSERT_EQ(state(1), SlaveState::starting);
  EXPECT_EQ(rig->master.release(slave(1), true), Refusal::none);
  drives->busy = {};
  rig->run(100);
  EXPECT_EQ(state(1), SlaveState::released);
  EXPECT_EQ(rig->told.count(Code::wrong_drive), 0u);
}

TEST_F(Identity, ADriveThatIsHeldDoesNotKeepTheOthersFromBeingAskedInSetUp) {
  drives->serial[1] = 7;
  set_up_and_wait();
  ASSERT_EQ(state(1), SlaveState::held);
  ASSERT_EQ(state(0), SlaveState::released);
  lose(0);
  EXPECT_EQ(state(0), SlaveState::lost);
  drives->serial[0] = 2000;
  bring_back(0);
  EXPECT_EQ(state(0), SlaveState::held);
  EXPECT_EQ(enable(1, 0), Refusal::slave_held);
}

TEST_F(Identity, IsReadAlsoWhereCursorsScan) {
  settings.command_channel.serving = Serving::scan;
  set_up_and_wait();
  for (unsigned n = 0; n < 3; ++n) EXPECT_EQ(state(n), SlaveState::released) << n;
}

TEST_F(Identity, ALineThatSaysWhoItsDrivesAreActivatesNoOthers) {
  set_up_and_wait();
  EXPECT_EQ(drives->activated.bits, 0x7u);
  settings.slaves[0].expect_count = settings.slaves[1].expect_count = 0;
  drives->activated = {};
  set_up_and_wait();
  EXPECT_EQ(drives->activated.bits, SlaveMask::all().bits);
}

}  // namespace
}  // namespace cansync::test
