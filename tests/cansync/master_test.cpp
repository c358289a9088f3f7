#include "master_rig.h"

namespace cansync::test {
namespace {

/// Slaves that can be silenced and unsynchronized one by one.
struct Line {
  SlaveMask silent;
  SlaveMask unsynchronized;
  unsigned reads = 0;

  std::optional<Telegram> operator()(const Telegram& telegram) {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr || silent.has(command->slave)) return std::nullopt;
    ++reads;
    return MasterRig::word_reply(*command, unsynchronized.has(command->slave) ? 0x0007 : 0x8007);
  }
};

TEST(StartUp, NothingIsSentBeforeSynchronousOperation) {
  MasterRig rig(settings_for(3));
  rig.run(5);
  EXPECT_EQ(rig.master.counters().telegrams_sent, 0u);
  EXPECT_EQ(rig.master.submit(ParameterRequest{}), Refusal::wrong_state);
  EXPECT_EQ(rig.master.control(ControlCommand::enable_active), Refusal::wrong_state);
}

TEST(StartUp, ASlaveThatAnswersAndNeverSynchronizesIsActivatedAgainEveryFiveSeconds) {
  MasterRig rig(settings_for(2));
  Line line;
  line.unsynchronized.set(slave(1));
  rig.answer = [&](const Telegram& telegram) { return line(telegram); };
  rig.set_up();
  std::vector<unsigned> activated;
  for (unsigned interval = 0; interval < 11'000; ++interval) {
    rig.step();
    for (const Telegram& telegram : rig.sent) {
      const auto* action = std::get_if<ActionCommand>(&telegram);
      if (action == nullptr) continue;
      EXPECT_EQ(action->slaves, interval == 0 ? SlaveMask::all() : SlaveMask::of(slave(1)));
      activated.push_back(interval);
    }
  }
  ASSERT_EQ(activated.size(), 3u);
  EXPECT_NEAR(activated[1], 5000, 5);
  EXPECT_NEAR(activated[2], 10'000, 10);
}

TEST(StartUp, ActivatesAllSlavesFirstAndThenReadsEveryStatusWordWithin33Intervals) {
  MasterRig rig(settings_for(32));
  rig.set_up();
  rig.step();
  // "SYNC mode: activate" to all slaves, before anything else; no reference values.
  ASSERT_EQ(rig.sent.size(), 1u);
  EXPECT_EQ(encode(rig.sent[0]),
            (can::Frame{.id = 0x010, .dlc = 8, .data = {0xFF, 0xFF, 0xFF, 0xFF, 2, 1, 0, 0}}));
  unsigned intervals = 1;
  for (; intervals < 33; ++intervals) {
    rig.step();
    ASSERT_EQ(rig.sent.size(), 1u);
    // Read parameter 301 of slave 0, 1, 2, ...
    EXPECT_EQ(encode(rig.sent[0]),
              (can::Frame{.id = 0x500 + intervals - 1, .dlc = 4, .data = {0x71, 0x2D, 0, 0, 0, 0, 0, 0}}));
  }
  for (unsigned i = 0; i < 32; ++i) {
    EXPECT_TRUE(rig.master.slave(slave(i)).status_known) << i;
    EXPECT_EQ(rig.master.slave(slave(i)).slave_register(), 3) << i;
  }
  EXPECT_EQ(rig.told.count(MasterEvent::Code::all_synchronized), 1u);
}

TEST(StartUp, CommandGoesOutEarlyInSetUpSoThatItsAnswerComesInTheSameInterval) {
  for (const SlotTimes& times : kSlotTimes) {
    MasterRig rig(settings_for(1, times.bit_rate));
    rig.set_up();
    const Duration answer_ends =
        rig.master.planned_start(Slot::command) + 2 * 135 * times.bit_time() + times.response_timeout;
    EXPECT_LT(answer_ends, times.interval) << times.bits_per_second;
    MasterRig active(settings_for(1, times.bit_rate));
    active.activate();
    EXPECT_EQ(active.master.planned_start(Slot::command), times.command - std::chrono::microseconds(50));
  }
}

TEST(StartUp, EnablingNeedsEverySlaveSynchronizedUnlessTheRuleOrForceSaysOtherwise) {
  auto line = std::make_shared<Line>();
  line->silent.set(slave(2));
  line->unsynchronized.set(slave(1));
  const auto rig_with = [&](EnableRule rule) {
    MasterSettings settings = settings_for(3);
    settings.startup.enable = rule;
    auto rig = std::make_unique<MasterRig>(settings);
    rig->answer = [line](const Telegram& t) { return (*line)(t); };
    rig->set_up();
    rig->run(50);
    return rig;
  };
  auto strict = rig_with(EnableRule::all_synchronized);
  EXPECT_EQ(strict->master.control(ControlCommand::enable_active), Refusal::slaves_missing);
  EXPECT_EQ(strict->master.control(ControlCommand::enable_active, true), Refusal::none);
  EXPECT_EQ(strict->master.state(), State::active_master);
  auto responding = rig_with(EnableRule::all_responding);
  EXPECT_EQ(responding->master.control(ControlCommand::enable_active), Refusal::slaves_missing);
  line->silent = {};
  responding->run(110);  // a slave that never answered is asked every 100 ms
  EXPECT_EQ(responding->master.control(ControlCommand::enable_active), Refusal::none);
  EXPECT_EQ(rig_with(EnableRule::any)->master.control(ControlCommand::enable_active), Refusal::none);
}

TEST(StartUp, UnsynchronizedSlavesAreAskedAgainUntilTheyAre) {
  auto line = std::make_shared<Line>();
  line->unsynchronized = SlaveMask::all();
  MasterRig rig(settings_for(4));
  rig.answer = [line](const Telegram& t) { return (*line)(t); };
  rig.set_up();
  rig.run(100);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_responds), 4u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_synchronized), 0u);
  EXPECT_EQ(rig.master.slave(slave(3)).slave_register(), 1);
  line->unsynchronized = {};
  rig.run(4);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_synchronized), 4u);
}

TEST(StartUp, JobsDoNotKeepSetUpFromReadingStatusWords) {
  auto line = std::make_shared<Line>();
  line->unsynchronized = SlaveMask::all();
  MasterRig rig(settings_for(2));
  rig.answer = [line](const Telegram& t) { return (*line)(t); };
  rig.set_up();
  rig.run(3);
  line->unsynchronized = {};
  for (JobId id = 1; id <= 100; ++id) {
    ASSERT_EQ(rig.master.submit(ParameterRequest{.id = id, .slave = slave(0), .number = parameter(5)}),
              Refusal::none);
  }
  rig.run(20);
  EXPECT_LT(rig.told.parameters.size(), 20u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_synchronized), 2u);
}

TEST(StartUp, ASlaveThatFallsSilentIsLostOnceAndActivatedAgainWhenItReturns) {
  auto line = std::make_shared<Line>();
  MasterSettings settings = settings_for(2);
  settings.startup.status_period = std::chrono::milliseconds(10);
  MasterRig rig(settings);
  rig.answer = [line](const Telegram& t) { return (*line)(t); };
  rig.activate();
  line->silent.set(slave(1));
  rig.run(200);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_lost), 1u);
  EXPECT_FALSE(rig.master.slave(slave(1)).responds);
  EXPECT_GE(rig.master.slave(slave(1)).unanswered, 3u);
  EXPECT_TRUE(rig.master.slave(slave(0)).responds);
  line->silent = {};
  bool activated = false;
  for (int i = 0; i < 50; ++i) {
    rig.step();
    const auto* action = rig.command() != nullptr ? std::get_if<ActionCommand>(rig.command()) : nullptr;
    if (action != nullptr) activated = *action == ActionCommand{SlaveMask::of(slave(1)), 2, 1, 0};
  }
  EXPECT_TRUE(activated);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_responds), 2u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_returned), 1u);
  EXPECT_EQ(rig.master.slave(slave(1)).slave_register(), 3);
}

TEST(StartUp, ASlaveThatStartsAnewBetweenTwoCommandsIsActivatedAgain) {
  auto line = std::make_shared<Line>();
  MasterSettings settings = settings_for(2);
  settings.startup.status_period = std::chrono::milliseconds(10);
  MasterRig rig(settings);
  unsigned activations = 0;
  rig.answer = [&, line](const Telegram& t) {
    if (const auto* action = std::get_if<ActionCommand>(&t)) {
      ++activations;
      // Nobody but the slave that needs it: the others go on undisturbed.
      if (activations == 2) {
        EXPECT_EQ(*action, (ActionCommand{SlaveMask::of(slave(1)), 2, 1, 0}));
      }
      line->unsynchronized = {};
    }
    return (*line)(t);
  };
  rig.activate();
  ASSERT_EQ(activations, 1u);
  line->unsynchronized.set(slave(1));
  rig.run(50);
  EXPECT_EQ(activations, 2u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_lost), 0u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_not_synchronized), 1u);
  EXPECT_EQ(rig.master.slave(slave(1)).slave_register(), 3);
}

TEST(StartUp, WithoutABusNoSlaveRespondsAndEachIsActivatedAgainWhenItAnswers) {
  MasterRig rig(settings_for(4));
  rig.activate();
  rig.master.bus_lost();
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_FALSE(rig.master.slave(slave(i)).responds);
    EXPECT_FALSE(rig.master.slave(slave(i)).synchronized);
  }
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_lost), 0u);
  SlaveMask activated;
  for (int i = 0; i < 50; ++i) {
    rig.step();
    const auto* action = rig.command() != nullptr ? std::get_if<ActionCommand>(rig.command()) : nullptr;
    if (action != nullptr && action->command == 2) activated.bits |= action->slaves.bits;
  }
  EXPECT_EQ(activated.bits, 0xFu);
  for (unsigned i = 0; i < 4; ++i) {
    EXPECT_TRUE(rig.master.slave(slave(i)).responds);
    EXPECT_TRUE(rig.master.slave(slave(i)).synchronized);
  }
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_responds), 4u);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::slave_returned), 4u);
}

TEST(StartUp, AfterTheBusWasLostNoSlaveIsEnabledBeforeItIsSynchronizedAgain) {
  MasterRig rig(settings_for(2));
  rig.activate();
  const ControlWordRequest enabling{.id = 1, .slave = slave(1), .control_word = 0x000F};
  ASSERT_EQ(rig.master.submit(enabling), Refusal::none) << "waits when the bus goes";
  rig.master.bus_lost();
  EXPECT_EQ(rig.master.submit(ControlWordRequest{2, slave(1), 0x000F}), Refusal::slave_lost);
  EXPECT_EQ(rig.master.submit(ControlWordRequest{3, slave(0), 0x0002}), Refusal::none) << "a quick stop";
  EXPECT_EQ(rig.master.submit(ParameterRequest{.id = 4, .slave = slave(1), .number = parameter(5)}),
            Refusal::slave_lost);
  rig.run_until([&] { return rig.master.slave(slave(1)).state == SlaveState::released; }, 100);
  EXPECT_EQ(rig.told.commands.at(1), Outcome::slave_lost);
  EXPECT_EQ(rig.told.commands.at(3), Outcome::done);
  EXPECT_EQ(rig.master.submit(ControlWordRequest{5, slave(1), 0x000F}), Refusal::none);
}

TEST(StartUp, WhereNobodyHadAnsweredTheActivationIsSentAgainWhenTheBusIsBack) {
  MasterRig rig(settings_for(2));
  rig.answer = [](const Telegram&) { return std::optional<Telegram>(); };
  rig.set_up();
  rig.step();
  ASSERT_NE(rig.command(), nullptr);
  const Telegram activation = *rig.command();
  ASSERT_TRUE(std::holds_alternative<ActionCommand>(activation));
  rig.master.bus_lost();  // nobody acknowledged it
  rig.step();
  ASSERT_NE(rig.command(), nullptr);
  EXPECT_EQ(*rig.command(), activation);
}

TEST(StartUp, ModeCanBeChangedAgainAfterAStart) {
  MasterRig rig(settings_for(2));
  rig.activate();
  EXPECT_EQ(rig.master.control(ControlCommand::start_synchronous), Refusal::none);
  EXPECT_EQ(rig.master.state(), State::setting_up_master);
  EXPECT_EQ(rig.master.control(ControlCommand::enable_active), Refusal::none);
  EXPECT_EQ(rig.master.control(ControlCommand::reset_can), Refusal::none);
  EXPECT_EQ(rig.master.state(), State::active_master);
  ASSERT_EQ(rig.master.submit(ParameterRequest{.id = 7, .slave = slave(0), .number = parameter(5)}),
            Refusal::none);
  EXPECT_EQ(rig.master.control(ControlCommand::cold_restart), Refusal::none);
  EXPECT_EQ(rig.told.parameters.at(7).outcome, Outcome::master_stopped);
  const auto before = rig.master.counters().telegrams_sent;
  rig.run(5);
  EXPECT_EQ(rig.master.counters().telegrams_sent, before);
}

TEST(StartUp, ASecondMasterIsReportedOnTheEdge) {
  MasterRig rig(settings_for(1));
  rig.activate();
  for (int i = 0; i < 20; ++i) {
    rig.step();
    rig.master.receive(encode(ReferenceTelegram{}), std::chrono::microseconds(400));
  }
  EXPECT_EQ(rig.told.count(MasterEvent::Code::second_master), 1u);
  EXPECT_EQ(rig.master.counters().second_master, 20u);
  EXPECT_TRUE(rig.master.second_master());
  rig.run(3000);
  EXPECT_EQ(rig.told.count(MasterEvent::Code::second_master_gone), 0u) << "3 s are not over";
  rig.run(2);
  ASSERT_EQ(rig.told.count(MasterEvent::Code::second_master_gone), 1u);
  EXPECT_EQ(rig.told.events.back().detail, 20u);
  EXPECT_FALSE(rig.master.second_master());
  rig.master.receive(encode(ReferenceTelegram{}), std::chrono::microseconds(400));
  EXPECT_EQ(rig.told.count(MasterEvent::Code::second_master), 2u);
}

TEST(StartUp, WhileTheLineIsStoppedASecondMasterIsForgottenAndWordsHaveTheirWholeTime) {
  MasterRig rig(settings_for(1));
  rig.activate();
  rig.step();
  rig.master.receive(encode(ReferenceTelegram{}), std::chrono::microseconds(400));
  ASSERT_EQ(rig.master.control(ControlCommand::cold_restart), Refusal::none);
  EXPECT_TRUE(rig.master.second_master());
  for (unsigned i = 0; i < 5000; ++i) rig.master.pass_interval(rig.next_interval++);
  EXPECT_FALSE(rig.master.second_master());
  EXPECT_EQ(rig.told.count(MasterEvent::Code::second_master_gone), 1u);
  rig.set_up();
  EXPECT_EQ(rig.master.submit(ControlWordRequest{.id = 1, .slave = slave(0), .control_word = 0x0006}),
            Refusal::none);
  rig.run(10);
  EXPECT_EQ(rig.told.commands.at(1), Outcome::done);
}

TEST(StartUp, AMasterIsKnownByItsIdentifierAlone) {
  MasterRig rig(settings_for(1));
  rig.activate();
  can::Frame frame;
  frame.dlc = 1;  // no telegram has this length
  for (const std::uint32_t id : {0x010u, 0x100u, 0x17Fu, 0x180u, 0x1FFu, 0x500u, 0x57Fu}) {
    frame.id = id;
    rig.master.receive(frame, std::chrono::microseconds(400));
  }
  EXPECT_EQ(rig.master.counters().second_master, 7u);
  for (const std::uint32_t id : {0x011u, 0x080u, 0x200u, 0x301u, 0x381u, 0x581u}) {
    frame.id = id;
    rig.master.receive(frame, std::chrono::microseconds(400));
  }
  EXPECT_EQ(rig.master.counters().second_master, 7u);
}

}  // namespace
}  // namespace cansync::test
