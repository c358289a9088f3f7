#include "master_rig.h"

namespace cansync::test {
namespace {

/// Answers every parameter command at once; status words are synchronized ones.
std::optional<Telegram> obedient(const Telegram& telegram) {
  const auto* command = std::get_if<ParameterCommand>(&telegram);
  if (command == nullptr) return std::nullopt;
  return command->kind == ParameterCommand::Kind::read ? MasterRig::word_reply(*command, 0x8001)
                                                       : MasterRig::written_reply(*command);
}

/// An active line of `count` slaves without status polling.
std::unique_ptr<MasterRig> active_line(MasterSettings settings) {
  settings.startup.status_period = Duration(0);
  settings.startup.lost_after = 255;  // its slaves answer no transfers
  auto rig = std::make_unique<MasterRig>(settings);
  rig->answer = obedient;
  rig->activate();
  return rig;
}

/// Intervals from one finished job to the next when 50 reads of slave `number` are waiting all the time.
std::vector<IntervalNumber> saturated_reads(MasterRig& rig, unsigned number) {
  for (JobId id = 1; id <= 50; ++id) {
    EXPECT_EQ(rig.master.submit(ParameterRequest{.id = id, .slave = slave(number), .number = parameter(5)}),
              Refusal::none);
  }
  std::vector<IntervalNumber> finished;
  rig.run_until([&] {
    while (finished.size() < rig.told.parameters.size()) finished.push_back(rig.next_interval);
    return finished.size() == 50;
  });
  std::vector<IntervalNumber> gaps;
  for (std::size_t i = 1; i < finished.size(); ++i) gaps.push_back(finished[i] - finished[i - 1]);
  return gaps;
}

TEST(CommandChannel, WorkConservingServesSaturatedReadsOfOneSlaveInOneIntervalEach) {
  auto rig = active_line(settings_for(32));
  for (const IntervalNumber gap : saturated_reads(*rig, 17)) EXPECT_EQ(gap, 1u);
}

TEST(CommandChannel, ScanServesSaturatedReadsOfOneOf32SlavesIn32IntervalsEach) {
  MasterSettings settings = settings_for(32);
  settings.command_channel.serving = Serving::scan;
  auto rig = active_line(settings);
  for (const IntervalNumber gap : saturated_reads(*rig, 17)) EXPECT_EQ(gap, 32u);
}

TEST(CommandChannel, ScanWithAFixedCursorServesThatSlaveInEveryInterval) {
  MasterSettings settings = settings_for(32);
  settings.command_channel.serving = Serving::scan;
  settings.command_channel.parameter = {Cursor::Kind::fixed, slave(17)};
  auto rig = active_line(settings);
  for (const IntervalNumber gap : saturated_reads(*rig, 17)) EXPECT_EQ(gap, 1u);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 100, .slave = slave(3), .number = parameter(5)}),
            Refusal::none);
  rig->run(100);
  EXPECT_FALSE(rig->told.parameters.contains(100));
  EXPECT_EQ(rig->master.set_command_cursors({}, {}, {}), Refusal::none);
  rig->run(33);
  EXPECT_TRUE(rig->told.parameters.contains(100));
  EXPECT_EQ(rig->master.set_command_cursors({}, {Cursor::Kind::nobody, {}}, {}), Refusal::none);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 101, .slave = slave(3), .number = parameter(5)}),
            Refusal::none);
  rig->run(100);
  EXPECT_FALSE(rig->told.parameters.contains(101));
}

// M 4.6: "polls up to this number". A job above it waits for ever with the manuals' service alone.
TEST(CommandChannel, TheMaximumSlaveNumberBoundsTheScanAndNotTheWorkConservingService) {
  for (const bool scan : {false, true}) {
    MasterSettings settings = settings_for(32);
    settings.process.maximum_slave = slave(3);
    if (scan) settings.command_channel.serving = Serving::scan;
    auto rig = active_line(settings);
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(7), .number = parameter(5)}),
              Refusal::none);
    rig->run(200);
    EXPECT_EQ(rig->told.parameters.contains(1), !scan);
  }
}

TEST(CommandChannel, WorkConservingIsRoundRobinAmongSlaves) {
  auto rig = active_line(settings_for(32));
  JobId id = 0;
  for (int round = 0; round < 3; ++round) {
    for (const unsigned number : {4u, 9u, 30u}) {
      ASSERT_EQ(
          rig->master.submit(ParameterRequest{.id = ++id, .slave = slave(number), .number = parameter(5)}),
          Refusal::none);
    }
  }
  std::vector<unsigned> order;
  for (int i = 0; i < 9; ++i) {
    rig->step();
    order.push_back(std::get<ParameterCommand>(*rig->command()).slave.value());
  }
  EXPECT_EQ(order, (std::vector<unsigned>{4, 9, 30, 4, 9, 30, 4, 9, 30}));
}

/// Submits one job of each kind, the least urgent first, and returns the kinds in the order in which they
/// were sent.
TEST(CommandChannel, OneCommandPerIntervalInTheOrderOfPriority) {
  MasterSettings settings = settings_for(4);
  settings.command_channel.minimum_share = 0;
  auto rig = active_line(settings);
  std::array<std::uint8_t, 6> data{};
  ASSERT_EQ(rig->master.submit(TransferRequest{.id = 1, .slave = slave(1), .address = 0x1000, .data = data}),
            Refusal::none);
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 2, .slave = slave(2), .number = parameter(5)}),
            Refusal::none);
  ASSERT_EQ(rig->master.submit(ControlWordRequest{3, slave(3), 0x000F}), Refusal::none);
  for (const std::uint8_t priority : std::to_array<std::uint8_t>({2, 1, 0})) {
    ASSERT_EQ(
        rig->master.submit(BroadcastRequest{
            static_cast<JobId>(10 + priority), priority, {SlaveMask{0x0000000F}, 200, priority, 0x1234}}),
        Refusal::none);
  }
  std::vector<can::Frame> frames;
  for (int i = 0; i < 6; ++i) {
    rig->step();
    ASSERT_EQ(rig->sent.size(), 1u);
    frames.push_back(encode(rig->sent[0]));
  }
  EXPECT_EQ(frames[0], (can::Frame{.id = 0x010, .dlc = 8, .data = {0x0F, 0, 0, 0, 200, 0, 0x34, 0x12}}));
  EXPECT_EQ(frames[1], (can::Frame{.id = 0x010, .dlc = 8, .data = {0x0F, 0, 0, 0, 200, 1, 0x34, 0x12}}));
  EXPECT_EQ(frames[2], (can::Frame{.id = 0x010, .dlc = 8, .data = {0x0F, 0, 0, 0, 200, 2, 0x34, 0x12}}));
  EXPECT_EQ(frames[3], (can::Frame{.id = 0x010, .dlc = 8, .data = {0x08, 0, 0, 0, 1, 0, 0x0F, 0}}));
  EXPECT_EQ(frames[4], (can::Frame{.id = 0x502, .dlc = 4, .data = {0x70, 0x05, 0, 0, 0, 0, 0, 0}}));
  EXPECT_EQ(frames[5], (can::Frame{.id = 0x501, .dlc = 8, .data = {0x90, 0x06, 0x00, 0x10, 0, 0, 0, 0}}));
  for (const JobId id : {3u, 10u, 11u, 12u}) EXPECT_EQ(rig->told.commands.at(id), Outcome::done);
}

/// Sends a control word in every interval and counts parameter and transfer telegrams among `intervals`
/// commands.
std::pair<unsigned, unsigned> share_against_control_words(std::uint32_t share, unsigned intervals) {
  MasterSettings settings = settings_for(4);
  settings.command_channel.minimum_share = share;
  auto rig = active_line(settings);
  static std::array<std::uint8_t, 4000> data;
  for (JobId id = 1; id <= 200; ++id) {
    EXPECT_EQ(rig->master.submit(ParameterRequest{.id = id, .slave = slave(2), .number = parameter(5)}),
              Refusal::none);
  }
  EXPECT_EQ(
      rig->master.submit(TransferRequest{.id = 1000, .slave = slave(1), .address = 0x1000, .data = data}),
      Refusal::none);
  unsigned parameters = 0;
  unsigned transfers = 0;
  for (unsigned i = 0; i < intervals; ++i) {
    // Refused when the queue is full, which also means that one is waiting.
    static_cast<void>(
        rig->master.submit(ControlWordRequest{2000 + i, slave(3), static_cast<std::uint16_t>(i)}));
    rig->step();
    if (std::holds_alternative<ParameterCommand>(*rig->command())) ++parameters;
    if (std::holds_alternative<TransferInitialise>(*rig->command())) ++transfers;
  }
  return {parameters, transfers};
}

TEST(CommandChannel, JobsKeepTheirMinimumShareAgainstAControlWordInEveryInterval) {
  // Both are due at the same time; the transfer follows one interval later.
  EXPECT_EQ(share_against_control_words(8, 80), std::pair(10u, 9u));
}

TEST(CommandChannel, AShareWhoseCommandWasLeftOutIsStillDue) {
  auto rig = active_line(settings_for(4));
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(2), .number = parameter(5)}),
            Refusal::none);
  for (JobId i = 0; i < 9; ++i) {
    ASSERT_EQ(rig->master.submit(ControlWordRequest{2000 + i, slave(3), 0x0F}), Refusal::none);
    rig->leave_out_command = i == 7;  // the one that has the share
    rig->step();
    if (i == 7) continue;
    EXPECT_EQ(std::holds_alternative<ParameterCommand>(*rig->command()), i == 8) << i;
  }
}

TEST(CommandChannel, WithoutAMinimumShareControlWordsStarveJobsAsInTheManuals) {
  EXPECT_EQ(share_against_control_words(0, 80), std::pair(0u, 0u));
}

TEST(CommandChannel, SaturatedParametersLeaveTransfersTheirShare) {
  auto rig = active_line(settings_for(4));
  std::array<std::uint8_t, 600> data{};
  for (JobId id = 1; id <= 100; ++id) {
    ASSERT_EQ(rig->master.submit(ParameterRequest{.id = id, .slave = slave(2), .number = parameter(5)}),
              Refusal::none);
  }
  ASSERT_EQ(
      rig->master.submit(TransferRequest{.id = 1000, .slave = slave(1), .address = 0x1000, .data = data}),
      Refusal::none);
  unsigned transfers = 0;
  for (int i = 0; i < 80; ++i) {
    rig->step();
    if (std::holds_alternative<TransferInitialise>(*rig->command())) ++transfers;
  }
  EXPECT_EQ(transfers, 10u);
}

TEST(CommandChannel, NothingGoesBeforeBroadcastZero) {
  auto rig = active_line(settings_for(4));
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(2), .number = parameter(5)}),
            Refusal::none);
  for (JobId id = 10; id < 60; ++id) {
    ASSERT_EQ(rig->master.submit(BroadcastRequest{id, 0, {SlaveMask{1}, 200, 0, 0}}), Refusal::none);
    rig->step();
    ASSERT_TRUE(std::holds_alternative<ActionCommand>(*rig->command()));
  }
}

TEST(CommandChannel, RefusesBroadcastsThatAreNotAllowed) {
  auto rig = active_line(settings_for(4));
  const auto submit = [&](std::uint8_t priority, std::uint32_t mask, std::uint8_t command) {
    return rig->master.submit(BroadcastRequest{1, priority, {SlaveMask{mask}, command, 0, 0}});
  };
  EXPECT_EQ(submit(3, 1, 200), Refusal::priority);
  EXPECT_EQ(submit(0, 0, 200), Refusal::no_slaves);
  for (const std::uint8_t command : std::to_array<std::uint8_t>({0, 2, 127}))
    EXPECT_EQ(submit(0, 1, command), Refusal::command_reserved);
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(rig->master.submit(BroadcastRequest{static_cast<JobId>(i), 1, {SlaveMask{1}, 1, 0, 0}}),
              Refusal::none);
  }
  EXPECT_EQ(rig->master.submit(ControlWordRequest{100, slave(0), 0}), Refusal::none);
  EXPECT_EQ(submit(1, 1, 200), Refusal::queue_full);
  EXPECT_EQ(rig->master.submit(ControlWordRequest{1, slave(9), 0}), Refusal::slave_not_configured);
  EXPECT_EQ(rig->master.cancel(3), Refusal::none);
  EXPECT_EQ(rig->master.cancel(100), Refusal::none);
  rig->run(20);
  EXPECT_EQ(rig->told.commands.at(3), Outcome::cancelled);
  EXPECT_EQ(rig->told.commands.at(100), Outcome::cancelled);
  EXPECT_EQ(rig->told.commands.size(), 9u);
}

TEST(CommandChannel, ABroadcastToAllSlavesHasAllBitsOfTheMask) {
  auto rig = active_line(settings_for(4));
  ASSERT_EQ(rig->master.submit(BroadcastRequest{1, 0, {SlaveMask::all(), 1, 0, 0x0F}}), Refusal::none);
  rig->step();
  ASSERT_NE(rig->command(), nullptr);
  EXPECT_EQ(encode(*rig->command()),
            (can::Frame{.id = 0x010, .dlc = 8, .data = {0xFF, 0xFF, 0xFF, 0xFF, 1, 0, 0x0F, 0}}));
}

TEST(CommandChannel, ACommandLeftOutIsSentInALaterInterval) {
  auto rig = active_line(settings_for(4));
  ASSERT_EQ(rig->master.submit(ControlWordRequest{1, slave(0), 7}), Refusal::none);
  rig->leave_out_command = true;
  rig->step();
  EXPECT_TRUE(rig->told.commands.empty());
  rig->step();
  EXPECT_EQ(rig->told.commands.at(1), Outcome::done);
}

TEST(CommandChannel, ManyJobsEachEndExactlyOnce) {
  auto rig = active_line(settings_for(32));
  unsigned accepted = 0;
  for (JobId id = 1; id <= 3000; ++id) {
    const Refusal refusal =
        rig->master.submit(ParameterRequest{.id = id, .slave = slave(id % 32), .number = parameter(5)});
    if (refusal == Refusal::none) ++accepted;
    if (id % 3 == 0) rig->step();
    if (id % 50 == 0) static_cast<void>(rig->master.cancel(id - 10));
  }
  EXPECT_EQ(rig->master.control(ControlCommand::cold_restart), Refusal::none);
  EXPECT_EQ(rig->told.terminal, accepted);
  EXPECT_EQ(rig->master.open_parameter_jobs(), 0u);
}

TEST(CommandChannel, AnAnswerThatComesBeforeItsCommandWasOnTheBusBelongsToAnEarlierOne) {
  auto rig = active_line(settings_for(1));
  Master& master = rig->master;
  ASSERT_EQ(master.submit(ParameterRequest{.id = 1, .slave = slave(0), .number = parameter(5)}),
            Refusal::none);
  master.begin_interval(rig->next_interval++);
  const auto command = master.take(Slot::command);
  ASSERT_TRUE(command);
  master.sent(Slot::command);
  // Two bytes of payload: the confirmation of a write, which as an answer to a read would be the value 0.
  const can::Frame confirmation = encode(ParameterReply{slave(0), parameter(5), false, false, 2, {}});
  master.receive(confirmation, std::chrono::microseconds(920));
  EXPECT_TRUE(rig->told.parameters.empty());
  EXPECT_EQ(master.counters().unexpected, 1u);
  master.transmitted(*command, std::chrono::microseconds(990));
  master.begin_interval(rig->next_interval++);
  const Decoded asked = decode(*command);
  const auto& read = std::get<ParameterCommand>(std::get<Telegram>(asked));
  master.receive(encode(MasterRig::word_reply(read, 77)), std::chrono::microseconds(100));
  ASSERT_EQ(rig->told.parameters.size(), 1u);
  EXPECT_EQ(rig->told.parameters.at(1).value, 77u);
}

TEST(CommandChannel, CountsAnswersLaterThanTheResponseTimeout) {
  auto rig = active_line(settings_for(1));
  ASSERT_EQ(rig->master.submit(ParameterRequest{.id = 1, .slave = slave(0), .number = parameter(5)}),
            Refusal::none);
  rig->answer = [](const Telegram&) { return std::nullopt; };
  rig->step();
  const can::Frame command = encode(*rig->command());
  rig->master.transmitted(command, std::chrono::microseconds(970));
  rig->master.begin_interval(rig->next_interval++);
  const auto reply = encode(MasterRig::word_reply(std::get<ParameterCommand>(*rig->command()), 1));
  // The answer of 92 bits ends 400 us after the command: it began 308 us after it, over the 300 us of tRSPTO.
  rig->master.receive(reply, std::chrono::microseconds(370));
  EXPECT_EQ(rig->told.parameters.at(1).outcome, Outcome::done);
  EXPECT_EQ(rig->master.slave(slave(0)).slow_answers, 1u);
  EXPECT_EQ(rig->master.slave(slave(0)).last_response, std::chrono::microseconds(400));
}

}  // namespace
}  // namespace cansync::test
