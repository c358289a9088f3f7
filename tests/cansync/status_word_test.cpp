// The status words of slaves: when they are read, refused, or taken from actual values.
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "cansync/settings/settings_check.h"
#include "master_rig.h"

namespace cansync::test {
namespace {

using Code = MasterEvent::Code;

// M 3.2.0.1 reads the status word; its parameter number is not in the manuals, so a real slave may not know
// it.
TEST(StatusWord, AnErrorIsToldOnceWithItsCodeUntilTheSlaveGivesIt) {
  MasterRig rig(settings_for(2));
  std::optional<ParameterError> refusal = ParameterError::not_present;
  rig.answer = [&](const Telegram& telegram) -> std::optional<Telegram> {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command != nullptr && command->slave == slave(1) && command->number.value() == 301 && refusal)
      return MasterRig::error_reply(*command, *refusal);
    return MasterRig::status_only(telegram);
  };
  rig.set_up();
  rig.run(1000);
  const SlaveStatus& status = rig.master.slave(slave(1));
  EXPECT_EQ(status.status_error, 0xFFFB);
  EXPECT_TRUE(status.responds && !status.synchronized && !status.status_known);
  EXPECT_EQ(rig.master.slave(slave(0)).status_error, 0);
  const auto is_it = [](const MasterEvent& event) { return event.code == Code::slave_status_refused; };
  ASSERT_EQ(rig.told.count(Code::slave_status_refused), 1u);
  const MasterEvent event = *std::find_if(rig.told.events.begin(), rig.told.events.end(), is_it);
  EXPECT_EQ(event.slave, slave(1));
  EXPECT_EQ(event.detail, 301u);
  EXPECT_EQ(event.found, 0xFFFBu);
  EXPECT_EQ(rig.told.statuses.at(1).status_error, 0xFFFB);

  // Another code is no other edge; nor is one that comes back within 5 s.
  refusal = ParameterError::not_available_now;
  rig.run(1000);
  EXPECT_EQ(status.status_error, 0xFFFA);
  refusal.reset();
  rig.run(1000);
  EXPECT_EQ(status.status_error, 0);
  EXPECT_TRUE(status.synchronized);
  EXPECT_EQ(rig.told.statuses.at(1).status_error, 0);
  refusal = ParameterError::not_present;
  rig.run(1000);
  EXPECT_EQ(status.status_error, 0xFFFB);
  EXPECT_TRUE(status.synchronized) << "nothing says that it is not";
  EXPECT_EQ(rig.told.count(Code::slave_status_refused), 1u);
  refusal.reset();
  rig.run(1000);
  refusal = ParameterError::not_present;
  rig.run(2000);
  EXPECT_EQ(rig.told.count(Code::slave_status_refused), 2u);
}

TEST(StatusWord, OfASlaveThatRefusesItIsReadUnderTheNumberOfItsParameterList) {
  constexpr unsigned kOfTheDrive = 400;
  const auto synchronized = [](unsigned number) {
    MasterSettings settings = settings_for(2);
    settings.slaves[1].status_parameter = static_cast<std::uint16_t>(number);
    MasterRig rig(settings);
    rig.answer = [](const Telegram& telegram) -> std::optional<Telegram> {
      const auto* command = std::get_if<ParameterCommand>(&telegram);
      if (command == nullptr || command->slave != slave(1) || command->kind != ParameterCommand::Kind::read)
        return MasterRig::status_only(telegram);
      if (command->number.value() != kOfTheDrive)
        return MasterRig::error_reply(*command, ParameterError::not_present);
      return MasterRig::word_reply(*command, 0x8000);
    };
    rig.set_up();
    rig.run(1000);
    EXPECT_EQ(rig.told.count(Code::slave_status_refused), number == kOfTheDrive ? 0u : 1u);
    return rig.master.slave(slave(1)).synchronized;
  };
  EXPECT_FALSE(synchronized(301));
  EXPECT_TRUE(synchronized(kOfTheDrive));
}

// M 3.2.1.4: whether the slave is synchronized cannot be known from "busy", nor from an answer without a value.
TEST(StatusWord, ASlaveThatIsBusyOrGivesNoValueForFiveSecondsIsToldOnce) {
  using Answer = Telegram (*)(const ParameterCommand&);
  const auto without_value = [](const ParameterCommand& asked) -> Telegram {
    return ParameterReply{asked.slave, asked.number, false, false, 0, {}};
  };
  for (const auto& [answer, outcome] : {std::pair<Answer, Outcome>{&MasterRig::busy_reply, Outcome::timeout},
                                        std::pair<Answer, Outcome>{without_value, Outcome::no_answer}}) {
    SCOPED_TRACE(name(outcome));
    MasterRig rig(settings_for(2));
    bool gives_it = false;
    rig.answer = [&, answer = answer](const Telegram& telegram) -> std::optional<Telegram> {
      const auto* command = std::get_if<ParameterCommand>(&telegram);
      if (command != nullptr && command->slave == slave(1) && command->number.value() == 301 && !gives_it)
        return answer(*command);
      return MasterRig::status_only(telegram);
    };
    rig.set_up();
    rig.run(4900);
    EXPECT_EQ(rig.told.count(Code::slave_status_refused), 0u) << "it may need a while";
    rig.run(10000);
    ASSERT_EQ(rig.told.count(Code::slave_status_refused), 1u);
    const MasterEvent event =
        *std::find_if(rig.told.events.begin(), rig.told.events.end(),
                      [](const MasterEvent& each) { return each.code == Code::slave_status_refused; });
    EXPECT_EQ(event.slave, slave(1));
    EXPECT_EQ(event.detail, 301u);
    EXPECT_EQ(event.outcome, outcome);
    EXPECT_TRUE(rig.master.slave(slave(1)).responds);
    EXPECT_FALSE(rig.master.slave(slave(1)).status_known);
    gives_it = true;
    rig.run(1000);
    EXPECT_TRUE(rig.master.slave(slave(1)).synchronized);
    gives_it = false;
    rig.run(4900);
    EXPECT_EQ(rig.told.count(Code::slave_status_refused), 1u);
    rig.run(1000);
    EXPECT_EQ(rig.told.count(Code::slave_status_refused), 2u);
  }
}

// M 3.2.3.7: another parameter number is a change of the job, and the slave forgets the one it was busy with.
TEST(StatusWord, IsNotReadFromASlaveThatIsBusyWithAJob) {
  MasterRig rig(settings_for(2));
  bool busy = true;
  unsigned writes = 0;
  unsigned reads_of_the_busy_one = 0;
  unsigned reads_between = 0;
  unsigned reads_of_the_other = 0;
  rig.answer = [&](const Telegram& telegram) -> std::optional<Telegram> {
    const auto* command = std::get_if<ParameterCommand>(&telegram);
    if (command == nullptr) return std::nullopt;
    if (command->number.value() == 301) {
      reads_of_the_busy_one += command->slave == slave(1) ? 1 : 0;
      reads_between += writes != 0 && busy && command->slave == slave(1) ? 1 : 0;
      reads_of_the_other += writes != 0 && command->slave == slave(0) ? 1 : 0;
      return MasterRig::word_reply(*command, 0);  // not synchronized: read again and again, beside jobs
    }
    ++writes;
    return busy ? MasterRig::busy_reply(*command) : MasterRig::written_reply(*command);
  };
  rig.set_up();
  rig.run(50);
  ASSERT_EQ(rig.master.submit(ParameterRequest{.id = 7,
                                               .write = true,
                                               .slave = slave(1),
                                               .number = parameter(100),
                                               .format = ParameterFormat::word,
                                               .value = 3,
                                               .monitoring_time = std::chrono::seconds(10)}),
            Refusal::none);
  rig.run(5000);
  // One may stand between the write and its first answer.
  EXPECT_EQ(reads_between, 0u);
  EXPECT_GE(reads_of_the_other, 100u);
  busy = false;
  rig.run_until([&] { return rig.told.parameters.contains(7); });
  EXPECT_EQ(rig.told.parameters.at(7).outcome, Outcome::done);
  const unsigned before = reads_of_the_busy_one;
  rig.run(100);
  EXPECT_GT(reads_of_the_busy_one, before);
}

/// Four slaves whose status word is the high word of actual value 5, in word 3 of RDC2 (M 3.1.1.1).
struct MappedStatus : testing::Test {
  MappedStatus() {
    settings.process.poll_without_reference = true;
    settings.startup.status_period = std::chrono::milliseconds(100);
    for (SlaveSettings& each : settings.slaves) each.status_value = ActualWord{5, true};
  }
  void start() {
    rig = std::make_unique<MasterRig>(settings);
    rig->answer = [this](const Telegram& telegram) -> std::optional<Telegram> {
      if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
        ++reads[command->slave.value()];
        return MasterRig::word_reply(*command, word_of(command->slave));
      }
      const auto* reference = std::get_if<ReferenceTelegram>(&telegram);
      if (reference == nullptr || reference->polled > 3 || silent.has(slave(reference->polled)))
        return std::nullopt;
      const std::uint16_t word = word_of(slave(reference->polled));
      return ActualTelegram{reference->channel, slave(reference->polled), 4, {0x1111, 0x2222, 0x3333, word}};
    };
    rig->activate();
    rig->run(100);  // what set-up has left due
    reads = {};
  }
  std::uint16_t word_of(SlaveNumber number) const { return unsynchronized.has(number) ? 0x0007 : 0x8007; }

  MasterSettings settings = settings_for(4);
  SlaveMask unsynchronized;
  SlaveMask silent;
  std::array<unsigned, kSlaves> reads = {};
  std::unique_ptr<MasterRig> rig;
};

TEST_F(MappedStatus, LossOfSynchronismIsSeenWithinOnePollingRoundWithoutAnyRead) {
  start();
  rig->run(1000);
  EXPECT_EQ(reads, (std::array<unsigned, kSlaves>{}));
  EXPECT_EQ(rig->master.slave(slave(2)).status_word, 0x8007);
  unsynchronized.set(slave(2));
  const unsigned intervals =
      rig->run_until([&] { return rig->told.count(Code::slave_not_synchronized) == 1; }, 5);
  EXPECT_LE(intervals, 4u);
  EXPECT_EQ(rig->master.slave(slave(2)).slave_register(), 1);
  EXPECT_EQ(rig->master.slave(slave(2)).status_word, 0x0007);
  EXPECT_EQ(rig->master.slave(slave(2)).state, SlaveState::returning);
  // It is activated anew, and what it says then is believed the same way.
  unsynchronized = {};
  rig->run_until([&] { return rig->master.slave(slave(2)).state == SlaveState::released; }, 10);
  EXPECT_EQ(reads, (std::array<unsigned, kSlaves>{}));
}

TEST_F(MappedStatus, WithoutTheTelegramOrTheWordTheParameterIsRead) {
  start();
  silent.set(slave(1));
  rig->run(1000);
  EXPECT_GE(reads[1], 5u);
  EXPECT_EQ(reads[0] + reads[2] + reads[3], 0u);
  silent = {};
  // Another mapping: the word no longer stands in a telegram.
  ASSERT_EQ(rig->master.set_actual_mapping(slave(3), {default_mapping(Channel::one), TelegramMapping{}}),
            Refusal::none);
  reads = {};
  rig->run(1000);
  EXPECT_EQ(reads[1], 0u);
  EXPECT_GE(reads[3], 9u);
}

TEST_F(MappedStatus, OfASlaveThatAnswersNoCommandIsNotBelieved) {
  start();
  rig->answer = [answer = rig->answer](const Telegram& telegram) {
    return std::holds_alternative<ParameterCommand>(telegram) ? std::nullopt : answer(telegram);
  };
  for (JobId id = 1; id <= 3; ++id)
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id, .slave = slave(0), .number = parameter(5)}),
              Refusal::none);
  rig->run_until([&] { return rig->master.slave(slave(0)).state == SlaveState::lost; }, 1000);
  rig->run(50);
  EXPECT_EQ(rig->master.slave(slave(0)).slave_register(), 0);
  EXPECT_EQ(rig->told.count(Code::slave_synchronized), 4u) << "of set-up alone";
}

TEST(MappedStatusSettings, TheWordMustStandInAMapping) {
  MasterSettings settings = settings_for(2);
  settings.slaves[1].status_value = ActualWord{5, true};
  EXPECT_TRUE(check(settings).empty());
  settings.slaves[1].status_value = ActualWord{6, false};
  const auto problems = check(settings);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].field, "slaves[1].status_value");
}

}  // namespace
}  // namespace cansync::test
