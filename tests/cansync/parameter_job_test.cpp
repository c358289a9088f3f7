#include "master_rig.h"

namespace cansync::test {
namespace {

using Kind = ParameterCommand::Kind;

/// A master in active operation with four slaves whose parameter answers each test scripts; status words are
/// answered.
struct ParameterJobs : testing::Test {
  MasterSettings settings = settings_for(4);
  std::unique_ptr<MasterRig> rig;
  std::vector<ParameterCommand> asked;
  std::function<std::optional<Telegram>(const ParameterCommand&)> script;

  void start() {
    settings.startup.status_period = Duration(0);
    rig = std::make_unique<MasterRig>(settings);
    rig->activate();
    rig->answer = [this](const Telegram& telegram) -> std::optional<Telegram> {
      const auto* command = std::get_if<ParameterCommand>(&telegram);
      if (command == nullptr) return std::nullopt;
      asked.push_back(*command);
      return script(*command);
    };
  }
  ParameterResult run(ParameterRequest request, unsigned most = 10'000) {
    if (!rig) start();
    request.id = 1;
    EXPECT_EQ(rig->master.submit(request), Refusal::none);
    rig->run_until([this] { return rig->told.parameters.contains(1); }, most);
    return rig->told.parameters[1];
  }
};

TEST_F(ParameterJobs, ReadsAWordInOneInterval) {
  script = [](const ParameterCommand& c) { return MasterRig::word_reply(c, 0xBEEF); };
  const ParameterResult result = run({.slave = slave(3), .number = parameter(0xABC)});
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.value, 0xBEEFu);
  EXPECT_FALSE(result.doubleword);
  EXPECT_EQ(result.intervals, 1u);
  ASSERT_EQ(asked.size(), 1u);
  EXPECT_EQ(encode(asked[0]), (can::Frame{.id = 0x503, .dlc = 4, .data = {0x7A, 0xBC, 0, 0, 0, 0, 0, 0}}));
}

TEST_F(ParameterJobs, ReadsADoublewordWithElementAndSubSlave) {
  script = [](const ParameterCommand& c) { return MasterRig::doubleword_reply(c, 0x12345678); };
  const ParameterResult result = run({.slave = slave(0),
                                      .sub_slave = {0x0102},
                                      .number = parameter(1),
                                      .element = *Element::from(3),
                                      .format = ParameterFormat::doubleword});
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.value, 0x12345678u);
  EXPECT_TRUE(result.doubleword);
  EXPECT_EQ(encode(asked[0]),
            (can::Frame{.id = 0x500, .dlc = 4, .data = {0x30, 0x01, 0x02, 0x01, 0, 0, 0, 0}}));
}

TEST_F(ParameterJobs, FormatOtherThanAskedNamesTheOneExpected) {
  script = [](const ParameterCommand& c) { return MasterRig::doubleword_reply(c, 5); };
  EXPECT_EQ(run({.number = parameter(1), .format = ParameterFormat::word}).outcome,
            Outcome::doubleword_expected);
  rig.reset();
  script = [](const ParameterCommand& c) { return MasterRig::word_reply(c, 5); };
  EXPECT_EQ(run({.number = parameter(1), .format = ParameterFormat::doubleword}).outcome,
            Outcome::word_expected);
}

TEST_F(ParameterJobs, WritesInBothFormats) {
  script = [](const ParameterCommand& c) { return MasterRig::written_reply(c); };
  EXPECT_EQ(
      run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 0x1234}).outcome,
      Outcome::done);
  EXPECT_EQ(encode(asked[0]),
            (can::Frame{.id = 0x500, .dlc = 6, .data = {0x70, 0x02, 0x34, 0x12, 0, 0, 0, 0}}));
  rig.reset();
  EXPECT_EQ(
      run({.write = true, .number = parameter(2), .format = ParameterFormat::doubleword, .value = 0x01020304})
          .outcome,
      Outcome::done);
  EXPECT_EQ(encode(asked[1]), (can::Frame{.id = 0x500, .dlc = 8, .data = {0x70, 0x02, 4, 3, 2, 1, 0, 0}}));
}

TEST_F(ParameterJobs, AWriteAsTheSlaveSaysReadsTheFormatFirst) {
  script = [](const ParameterCommand& c) {
    return c.kind == Kind::read ? MasterRig::doubleword_reply(c, 1) : MasterRig::written_reply(c);
  };
  const ParameterResult result = run({.write = true, .number = parameter(2), .value = 7});
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.value, 7u);
  ASSERT_EQ(asked.size(), 2u);
  EXPECT_EQ(asked[0].kind, Kind::read);
  EXPECT_EQ(asked[1].kind, Kind::write_doubleword);
}

TEST_F(ParameterJobs, AWriteAsTheSlaveSaysRefusesAValueTheWordCannotHold) {
  script = [](const ParameterCommand& c) { return MasterRig::word_reply(c, 1); };
  EXPECT_EQ(run({.write = true, .number = parameter(2), .value = 0x10000}).outcome, Outcome::value_too_wide);
  EXPECT_EQ(asked.size(), 1u);
}

TEST_F(ParameterJobs, BusyRepeatsTheSameTelegramUntilTheSlaveIsDone) {
  script = [this](const ParameterCommand& c) {
    return asked.size() < 6 ? MasterRig::busy_reply(c) : MasterRig::written_reply(c);
  };
  const ParameterResult result =
      run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9});
  EXPECT_EQ(result.outcome, Outcome::done);
  EXPECT_EQ(result.busy_replies, 5u);
  EXPECT_EQ(result.intervals, 6u);
  for (const ParameterCommand& command : asked) EXPECT_EQ(command, asked[0]);
}

TEST_F(ParameterJobs, EndlessBusyEndsAtTheMonitoringTimeOfThreeSeconds) {
  script = [](const ParameterCommand& c) { return MasterRig::busy_reply(c); };
  start();
  const IntervalNumber from = rig->next_interval;
  EXPECT_EQ(run({.number = parameter(2)}).outcome, Outcome::timeout);
  EXPECT_NEAR(static_cast<double>(rig->next_interval - from), 3000, 2);
}

TEST_F(ParameterJobs, MonitoringTimeOfTheRequestCounts) {
  settings.startup.lost_after = 255;
  script = [](const ParameterCommand&) { return std::nullopt; };
  start();
  const IntervalNumber from = rig->next_interval;
  EXPECT_EQ(run({.number = parameter(2), .monitoring_time = std::chrono::milliseconds(20)}).outcome,
            Outcome::timeout);
  EXPECT_NEAR(static_cast<double>(rig->next_interval - from), 20, 2);
  EXPECT_GT(asked.size(), 10u) << "an unanswered read is asked again";
}

TEST_F(ParameterJobs, AnUnansweredWriteIsNeverSentTwice) {
  script = [](const ParameterCommand&) { return std::nullopt; };
  EXPECT_EQ(run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9}).outcome,
            Outcome::no_answer);
  rig->run(50);
  EXPECT_EQ(asked.size(), 1u);
}

// The slave answers the first write an interval late, and refuses the second.
TEST_F(ParameterJobs, ALateAnswerConfirmsNoOtherWriteOfTheSameParameter) {
  std::optional<Telegram> late;
  script = [&](const ParameterCommand& c) -> std::optional<Telegram> {
    if (asked.size() > 1) return MasterRig::error_reply(c, ParameterError::wrong_format);
    late = MasterRig::written_reply(c);
    return std::nullopt;
  };
  start();
  const auto write = [&](JobId id, std::uint32_t value) {
    return rig->master.submit(ParameterRequest{
        .id = id, .write = true, .number = parameter(2), .format = ParameterFormat::word, .value = value});
  };
  ASSERT_EQ(write(1, 7), Refusal::none);
  ASSERT_EQ(write(2, 8), Refusal::none);
  rig->run_until([this] { return rig->told.parameters.contains(1); }, 20);
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::no_answer);
  rig->run(1);
  EXPECT_EQ(asked.size(), 1u) << "the answer of the first may still come";
  rig->master.receive(encode(*late), std::chrono::microseconds(500));
  rig->run_until([this] { return rig->told.parameters.contains(2); }, 20);
  EXPECT_EQ(rig->told.parameters.at(2).outcome, Outcome::slave_error);
  EXPECT_EQ(asked.size(), 2u);
}

TEST_F(ParameterJobs, AnUnansweredWriteIsRepeatedWhenTheSettingSaysSo) {
  settings.command_channel.repeat_unanswered_writes = true;
  script = [this](const ParameterCommand& c) {
    return asked.size() < 3 ? std::nullopt : std::optional(MasterRig::written_reply(c));
  };
  EXPECT_EQ(run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9}).outcome,
            Outcome::done);
  EXPECT_EQ(asked.size(), 3u);
}

TEST_F(ParameterJobs, AWriteThatWasLeftOutOfItsSlotIsSentInTheNext) {
  script = [](const ParameterCommand& c) { return MasterRig::written_reply(c); };
  start();
  rig->leave_out_command = true;
  EXPECT_EQ(run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9}).outcome,
            Outcome::done);
  EXPECT_EQ(asked.size(), 1u);
  EXPECT_EQ(rig->master.counters().left_out, 1u);
}

TEST_F(ParameterJobs, AReplyToAnotherNumberSlaveOrSubSlaveIsNotTheAnswer) {
  script = [this](const ParameterCommand& c) {
    ParameterCommand wrong = c;
    if (asked.size() == 1) wrong.number = parameter(99);
    if (asked.size() == 2) wrong.slave = slave(2);
    if (asked.size() == 3) wrong.sub_slave = {5};
    return MasterRig::word_reply(wrong, asked.size() == 4 ? 0x4444 : 0x1111);
  };
  const ParameterResult result = run({.slave = slave(1), .number = parameter(10)});
  EXPECT_EQ(result.value, 0x4444u);
  EXPECT_EQ(asked.size(), 4u);
  EXPECT_EQ(rig->master.counters().unexpected, 3u);
}

TEST_F(ParameterJobs, AReplyWithoutSubSlaveAddressIsAccepted) {
  script = [](const ParameterCommand& c) {
    return ParameterReply{c.slave, c.number, false, false, 2, {0x34, 0x12}};
  };
  EXPECT_EQ(run({.number = parameter(10)}).value, 0x1234u);
}

// Its high word stands where the address of the sub-slave is.
TEST_F(ParameterJobs, ADoublewordReplyWithoutSubSlaveAddressIsNotTaken) {
  script = [](const ParameterCommand& c) {
    return ParameterReply{c.slave, c.number, false, false, 4, {0x45, 0x23, 0x01, 0x00}};
  };
  EXPECT_EQ(run({.number = parameter(10)}).outcome, Outcome::timeout);
}

TEST_F(ParameterJobs, ALateConfirmationOfAWriteIsNotTheValueOfARead) {
  script = [](const ParameterCommand& c) { return MasterRig::written_reply(c); };
  ASSERT_EQ(
      run({.write = true, .number = parameter(10), .format = ParameterFormat::word, .value = 5}).outcome,
      Outcome::done);
  // The slave has shown that it sends the sub-slave address: two bytes are not a word without it.
  unsigned answers = 0;
  script = [&](const ParameterCommand& c) {
    return ++answers == 1 ? MasterRig::written_reply(c) : MasterRig::word_reply(c, 5);
  };
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 2, .slave = slave(0), .number = parameter(10)}),
            Refusal::none);
  rig->run_until([this] { return rig->told.parameters.contains(2); }, 10);
  EXPECT_EQ(rig->told.parameters[2].outcome, Outcome::done);
  EXPECT_EQ(rig->told.parameters[2].value, 5u);
  EXPECT_EQ(rig->master.counters().unexpected, 1u);
}

TEST_F(ParameterJobs, EverySlaveErrorIsHandedOn) {
  for (const auto error :
       {ParameterError::unspecified, ParameterError::below_minimum, ParameterError::above_maximum,
        ParameterError::not_changeable, ParameterError::not_present, ParameterError::not_available_now,
        ParameterError::wrong_format}) {
    rig.reset();
    script = [error](const ParameterCommand& c) { return MasterRig::error_reply(c, error); };
    const ParameterResult result =
        run({.write = true, .number = parameter(3), .format = ParameterFormat::word, .value = 1});
    EXPECT_EQ(result.outcome, Outcome::slave_error);
    EXPECT_EQ(result.error, error);
  }
}

TEST_F(ParameterJobs, RefusalsSendNothing) {
  script = [](const ParameterCommand& c) { return MasterRig::written_reply(c); };
  start();
  Master& master = rig->master;
  EXPECT_EQ(master.submit(ParameterRequest{.slave = slave(4)}), Refusal::slave_not_configured);
  EXPECT_EQ(master.submit(ParameterRequest{.write = true, .element = *Element::from(6)}),
            Refusal::element_not_writable);
  EXPECT_EQ(master.submit(ParameterRequest{.write = true, .format = ParameterFormat::word, .value = 0x10000}),
            Refusal::value_too_wide);
  EXPECT_EQ(master.cancel(77), Refusal::unknown_job);
  rig->run(10);
  EXPECT_TRUE(asked.empty());
}

TEST_F(ParameterJobs, QueueIsBoundedAndCancelEndsJobsOnce) {
  settings.command_channel.parameter_queue = 4;
  script = [](const ParameterCommand&) { return std::nullopt; };
  start();
  for (JobId id = 1; id <= 4; ++id) {
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id, .number = parameter(1)}), Refusal::none);
  }
  EXPECT_EQ(rig->master.submit(ParameterRequest{.id = 5, .number = parameter(1)}), Refusal::queue_full);
  rig->run(3);
  EXPECT_EQ(rig->master.cancel(1), Refusal::none);  // on its way
  EXPECT_EQ(rig->master.cancel(3), Refusal::none);  // waiting
  EXPECT_EQ(rig->master.cancel(3), Refusal::unknown_job);
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::cancelled);
  EXPECT_EQ(rig->told.parameters.at(3).outcome, Outcome::cancelled);
  EXPECT_EQ(rig->master.open_parameter_jobs(), 2u);
  EXPECT_EQ(rig->master.submit(ParameterRequest{.id = 5, .number = parameter(1)}), Refusal::none)
      << "one has ended";
}

/// Ctrl-C while the drive is busy for seconds: the drive has the value, so nobody is told "cancelled".
TEST_F(ParameterJobs, AWriteThatTheSlaveHasIsNotCancelled) {
  constexpr ParameterFormat kWord = ParameterFormat::word;
  bool busy = false;
  script = [&busy](const ParameterCommand& c) -> std::optional<Telegram> {
    if (!busy && c.kind != Kind::read) return std::nullopt;
    return MasterRig::busy_reply(c);
  };
  settings.startup.lost_after = 255;
  settings.command_channel.repeat_unanswered_writes = true;
  start();
  const auto cancelled = [this](JobId id, unsigned intervals, bool write) {
    static_cast<void>(rig->master.submit(ParameterRequest{.id = id,
                                                          .write = write,
                                                          .number = parameter(static_cast<unsigned>(id)),
                                                          .format = kWord,
                                                          .value = 9}));
    rig->run(intervals);
    EXPECT_EQ(rig->master.cancel(id), Refusal::none);
    return rig->told.parameters.at(id).outcome;
  };
  EXPECT_EQ(cancelled(1, 0, true), Outcome::cancelled) << "not sent";
  EXPECT_EQ(cancelled(2, 3, true), Outcome::no_answer) << "sent, and not answered";
  EXPECT_EQ(cancelled(3, 3, false), Outcome::cancelled) << "a read changes nothing";
  busy = true;
  EXPECT_EQ(cancelled(4, 3, true), Outcome::taken) << "the slave is busy with it";
  ASSERT_EQ(rig->master.submit(ParameterRequest{
                .id = 5, .write = true, .number = parameter(5), .format = kWord, .value = 9}),
            Refusal::none);
  rig->run(3);
  EXPECT_EQ(rig->master.control(ControlCommand::cold_restart), Refusal::none);
  EXPECT_EQ(rig->told.parameters.at(5).outcome, Outcome::taken) << "the master stops";
}

/// A write that is sent again is another one. The answer that was lost may have been "done".
TEST_F(ParameterJobs, AnErrorAfterALostAnswerDoesNotSayThatTheSlaveHasNothing) {
  const ParameterRequest write{
      .write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9};
  const auto error = [](const ParameterCommand& c) {
    return MasterRig::error_reply(c, ParameterError::not_available_now);
  };
  settings.startup.lost_after = 255;
  script = [&](const ParameterCommand& c) -> std::optional<Telegram> {
    if (asked.size() == 2) return std::nullopt;
    return asked.size() < 2 ? MasterRig::busy_reply(c) : error(c);
  };
  const ParameterResult result = run(write);
  EXPECT_EQ(result.outcome, Outcome::taken);
  EXPECT_EQ(result.error, ParameterError::none);
  EXPECT_EQ(asked.size(), 3u);
  asked.clear();
  rig->told.parameters.clear();
  script = [&](const ParameterCommand& c) -> std::optional<Telegram> {
    return asked.size() < 3 ? MasterRig::busy_reply(c) : error(c);
  };
  EXPECT_EQ(run(write).outcome, Outcome::slave_error) << "every answer came";
}

TEST_F(ParameterJobs, AnErrorOfAWriteThatWasRepeatedDoesNotSayThatTheSlaveHasNothing) {
  settings.command_channel.repeat_unanswered_writes = true;
  script = [this](const ParameterCommand& c) -> std::optional<Telegram> {
    if (asked.size() < 2) return std::nullopt;
    return MasterRig::error_reply(c, ParameterError::not_available_now);
  };
  EXPECT_EQ(run({.write = true, .number = parameter(2), .format = ParameterFormat::word, .value = 9}).outcome,
            Outcome::no_answer);
  EXPECT_EQ(asked.size(), 2u);
}

/// A busy answer to the read that asks for the format says nothing of the write that follows.
TEST_F(ParameterJobs, AWriteAfterABusyReadOfItsFormatIsNotSentTwice) {
  script = [this](const ParameterCommand& c) -> std::optional<Telegram> {
    if (c.kind != Kind::read) return std::nullopt;
    return asked.size() < 3 ? MasterRig::busy_reply(c) : MasterRig::word_reply(c, 1);
  };
  settings.startup.lost_after = 255;
  EXPECT_EQ(run({.write = true, .number = parameter(2), .value = 7}).outcome, Outcome::no_answer);
  EXPECT_EQ(std::count_if(asked.begin(), asked.end(),
                          [](const ParameterCommand& c) { return c.kind != Kind::read; }),
            1);
}

}  // namespace
}  // namespace cansync::test
