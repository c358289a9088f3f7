#include <gtest/gtest.h>

#include <numeric>

#include "good_requests.h"
#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using cansync::Outcome;

cansync_TransferRequest upload_request(std::uint64_t number, std::uint32_t length) {
  auto request = TestClient::request<cansync_TransferRequest>(number);
  request.direction = cansync_DIRECTION_UPLOAD;
  request.slave = 2;
  request.address = 0x1000;
  request.length = length;
  return request;
}

cansync_Command control_word(std::uint64_t number) {
  auto command = TestClient::request<cansync_Command>(number);
  command.kind = cansync_COMMAND_CONTROL_WORD;
  command.slave = 3;
  command.control_word = 0x000F;
  return command;
}

TEST(GatewayJobs, AReadReachesTheRealtimeThreadAndIsAnsweredOnce) {
  GatewayRig rig;
  rig.client.write(good_read(7));
  const auto job = rig.expect_request<cansync::ParameterRequest>();
  EXPECT_FALSE(job.write);
  EXPECT_EQ(job.slave, slave(1));
  EXPECT_EQ(job.number.value(), 301);
  EXPECT_EQ(job.format, cansync::ParameterFormat::as_slave_says);

  cansync::ParameterResult result;
  result.value = 0x12345678;
  result.doubleword = true;
  result.intervals = 3;
  rig.answer(ParameterDone{job.id, result});
  const auto reply = rig.client.reply<cansync_ParameterReply>(7);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
  EXPECT_STREQ(reply->reason, "");
  EXPECT_EQ(reply->value, 0x12345678u);
  EXPECT_TRUE(reply->doubleword);
  EXPECT_EQ(reply->intervals, 3u);

  // A second answer to the same job is nobody's: the next reply is the next request's.
  rig.answer(ParameterDone{job.id, result});
  rig.client.write(good_read(8));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, result});
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(8));
  EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(7), 0u);
}

TEST(GatewayJobs, AnOpenReadSurvivesAChangeOfTheNetwork) {
  GatewayRig rig;
  rig.client.write(good_read(7));
  const auto job = rig.expect_request<cansync::ParameterRequest>();
  rig.gateway->set_surroundings({"", {"lo", "another address", ""}});
  ASSERT_TRUE(rig.client.wait_for<gateway_Event>(
      [](const auto& event) { return gateway::dds::text(event.code) == "network_joined"; }));
  cansync::ParameterResult result;
  result.value = 0x1234;
  rig.answer(ParameterDone{job.id, result});
  const auto reply = rig.client.reply<cansync_ParameterReply>(7);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
  EXPECT_EQ(reply->value, 0x1234u);
}

TEST(GatewayJobs, ALostSlaveIsNamedInTheReply) {
  GatewayRig rig;
  rig.client.write(good_read(1));
  cansync::ParameterResult result;
  result.outcome = Outcome::slave_lost;
  const auto request = rig.expect_request<cansync::ParameterRequest>();
  rig.answer(ParameterDone{request.id, result});
  const auto reply = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_SLAVE_LOST);
  const std::string reason = reply->reason;
  EXPECT_TRUE(reason.starts_with("slave " + std::to_string(request.slave.value()))) << reason;
  EXPECT_NE(reason.find("stopped answering"), std::string::npos) << reason;
}

TEST(GatewayJobs, EveryOutcomeHasItsReplyCode) {
  GatewayRig rig;
  const std::pair<Outcome, gateway_ReplyCode> outcomes[] = {
      {Outcome::done, gateway_REPLY_DONE},
      {Outcome::slave_error, gateway_REPLY_SLAVE_ERROR},
      {Outcome::timeout, gateway_REPLY_TIMEOUT},
      {Outcome::no_answer, gateway_REPLY_NO_ANSWER},
      {Outcome::word_expected, gateway_REPLY_WORD_EXPECTED},
      {Outcome::doubleword_expected, gateway_REPLY_DOUBLEWORD_EXPECTED},
      {Outcome::value_too_wide, gateway_REPLY_VALUE_TOO_WIDE},
      {Outcome::cancelled, gateway_REPLY_CANCELLED},
      {Outcome::master_stopped, gateway_REPLY_MASTER_STOPPED},
      {Outcome::slave_lost, gateway_REPLY_SLAVE_LOST},
      {Outcome::slave_held, gateway_REPLY_REFUSED},
      {Outcome::replaced, gateway_REPLY_REPLACED},
  };
  std::uint64_t number = 1;
  for (const auto& [outcome, code] : outcomes) {
    rig.client.write(good_read(number));
    cansync::ParameterResult result;
    result.outcome = outcome;
    if (outcome == Outcome::slave_error) result.error = cansync::ParameterError::above_maximum;
    rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, result});
    const auto reply = rig.client.reply<cansync_ParameterReply>(number);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, code) << cansync::name(outcome);
    EXPECT_EQ(reply->error_code, outcome == Outcome::slave_error ? 0xFFFD : 0);
    EXPECT_EQ(std::string_view(reply->reason).empty(), outcome == Outcome::done);
    ++number;
  }
}

TEST(GatewayJobs, ADownloadIsGivenToTheRealtimeThreadWithItsData) {
  GatewayRig rig;
  std::vector<std::uint8_t> data(1000);
  std::iota(data.begin(), data.end(), std::uint8_t{0});
  auto request = upload_request(1, 1000);
  request.direction = cansync_DIRECTION_DOWNLOAD;
  request.data = {1000, 1000, data.data(), false};
  rig.client.write(request);
  const auto job = rig.expect_request<cansync::TransferRequest>();
  EXPECT_EQ(job.direction, cansync::TransferRequest::Direction::download);
  EXPECT_EQ(job.address, 0x1000u);
  EXPECT_EQ(std::vector<std::uint8_t>(job.data.begin(), job.data.end()), data);

  const auto progress = rig.client.ask_for<cansync_TransferProgress>(
      [&] {
        rig.report(TransferProgress{job.id, 300});
      },
      [](const auto& p) { return p.request == 1 && p.done == 300; });
  ASSERT_TRUE(progress);
  EXPECT_EQ(progress->total, 1000u);

  cansync::TransferResult result;
  result.bytes = 1000;
  result.repeated_telegrams = 2;
  rig.answer(TransferDone{job.id, result});
  const auto answer = rig.transfer_reply(1);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reply.code, gateway_REPLY_DONE);
  EXPECT_EQ(answer->reply.done, 1000u);
  EXPECT_EQ(answer->reply.repeated_telegrams, 2u);
  EXPECT_TRUE(answer->data.empty());
}

TEST(GatewayJobs, AnUploadBringsWhatTheRealtimeThreadWrote) {
  GatewayRig rig;
  rig.client.write(upload_request(1, 700));
  const auto job = rig.expect_request<cansync::TransferRequest>();
  ASSERT_EQ(job.data.size(), 700u);
  std::iota(job.data.begin(), job.data.end(), std::uint8_t{5});
  // The slave had less than was asked for.
  const std::vector<std::uint8_t> expected(job.data.begin(), job.data.begin() + 650);
  cansync::TransferResult result;
  result.bytes = 650;
  rig.answer(TransferDone{job.id, result});
  const auto answer = rig.transfer_reply(1);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->data, expected);
}

TEST(GatewayJobs, TheNewestControlWordOfASlaveReplacesWhatWaitsForItsTurn) {
  GatewayRig rig;
  std::vector<cansync::JobId> given;
  for (std::uint64_t number = 1; number <= 4; ++number) {
    rig.client.write(control_word(number));
    given.push_back(rig.expect_request<cansync::ControlWordRequest>().id);
  }
  rig.client.write(control_word(5));
  rig.client.write(control_word(6));
  auto stop = control_word(7);
  stop.control_word = 0x0006;
  stop.timeout = 250;
  rig.client.write(stop);
  for (const std::uint64_t number : {5u, 6u}) {
    const auto reply = rig.client.reply<cansync_CommandReply>(number);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, gateway_REPLY_REPLACED);
    EXPECT_NE(std::string_view(reply->reason).find("newer control word"), std::string_view::npos);
  }
  rig.answer(CommandDone{given[0], Outcome::replaced});
  EXPECT_EQ(rig.client.reply<cansync_CommandReply>(1)->code, gateway_REPLY_REPLACED);
  const auto last = rig.expect_request<cansync::ControlWordRequest>();
  EXPECT_EQ(last.control_word, 0x0006);
  EXPECT_EQ(last.monitoring_time, std::chrono::milliseconds(250));
  EXPECT_FALSE(last.failsafe);
}

TEST(GatewayJobs, AStopReplacesWaitingBroadcastsThatWouldEnableItsSlave) {
  GatewayRig rig;
  auto broadcast = TestClient::request<cansync_Command>(1);
  broadcast.kind = cansync_COMMAND_BROADCAST;
  broadcast.priority = 2;
  broadcast.slave_mask = 0b1010;
  broadcast.action = 1;
  broadcast.data_word = 0x000F;
  for (; broadcast.request <= 4; ++broadcast.request) {
    rig.client.write(broadcast);
    rig.expect_request<cansync::BroadcastRequest>();
  }
  rig.client.write(broadcast);  // the fifth waits for its turn
  auto stop = control_word(6);
  stop.control_word = 0;
  rig.client.write(stop);
  const auto reply = rig.client.reply<cansync_CommandReply>(5);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_REPLACED);
  EXPECT_EQ(rig.expect_request<cansync::ControlWordRequest>().control_word, 0);
}

TEST(GatewayJobs, CommandsBecomeRequests) {
  GatewayRig rig;
  rig.client.write(control_word(1));
  const auto word = rig.expect_request<cansync::ControlWordRequest>();
  EXPECT_EQ(word.slave, slave(3));
  EXPECT_EQ(word.control_word, 0x000F);
  rig.answer(CommandDone{word.id, Outcome::done});
  ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(1));

  auto command = TestClient::request<cansync_Command>(2);
  command.kind = cansync_COMMAND_BROADCAST;
  command.priority = 1;
  command.slave_mask = 0b101;
  command.action = 130;
  command.data_byte = 0xAB;
  command.data_word = 0xCDEF;
  rig.client.write(command);
  const auto broadcast = rig.expect_request<cansync::BroadcastRequest>();
  EXPECT_EQ(broadcast.priority, 1);
  EXPECT_EQ(broadcast.action, (cansync::ActionCommand{{0b101}, 130, 0xAB, 0xCDEF}));

  command = TestClient::request<cansync_Command>(3);
  command.kind = cansync_COMMAND_MODE;
  command.mode = cansync_MODE_RUN;
  command.force = true;
  rig.client.write(command);
  const auto mode = rig.expect_request<ModeRequest>();
  EXPECT_EQ(mode.mode, Mode::run);
  EXPECT_TRUE(mode.force);

  command = TestClient::request<cansync_Command>(4);
  command.kind = cansync_COMMAND_POLLING;
  command.polling_one = -128;
  command.polling_two = -2;
  command.maximum_slave = 3;
  rig.client.write(command);
  const auto polling = rig.expect_request<SetPolling>();
  EXPECT_EQ(polling.polling[0], (cansync::Cursor{cansync::Cursor::Kind::automatic, {}}));
  EXPECT_FALSE(polling.polling[1]);
  EXPECT_EQ(polling.maximum_slave, slave(3));

  command = TestClient::request<cansync_Command>(5);
  command.kind = cansync_COMMAND_CHANNEL_CURSORS;
  command.cursor_control_word = -2;
  command.cursor_parameter = 2;
  command.cursor_transfer = -1;
  rig.client.write(command);
  const auto cursors = rig.expect_request<SetCursors>();
  EXPECT_FALSE(cursors.control_word);
  EXPECT_EQ(cursors.parameter, (cansync::Cursor{cansync::Cursor::Kind::fixed, slave(2)}));
  EXPECT_EQ(cursors.transfer->kind, cansync::Cursor::Kind::nobody);
}

TEST(GatewayJobs, MappingCommandsCarryTheRegisterBytes) {
  GatewayRig rig;
  auto command = TestClient::request<cansync_Command>(1);
  command.kind = cansync_COMMAND_ACTUAL_MAPPING;
  command.slave = 2;
  command.mapping[0] = 0x0D;
  rig.client.write(command);
  const auto actual = rig.expect_request<SetActualMapping>();
  EXPECT_EQ(actual.slave, slave(2));
  EXPECT_EQ(actual.mapping[0].word[0], (cansync::WordMapping{true, false, 3}));
  EXPECT_FALSE(actual.mapping[0].word[1].assigned);

  command.request = 2;
  command.kind = cansync_COMMAND_REFERENCE_MAPPING;
  rig.client.write(command);
  const auto reference = rig.expect_request<SetReferenceMapping>();
  EXPECT_EQ(reference.mapping, actual.mapping);
  rig.answer(CommandDone{reference.id, Outcome::done});
  const auto reply = rig.client.reply<cansync_CommandReply>(2);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
}

TEST(GatewayJobs, CancelGoesToTheJobAndTheJobAnswers) {
  GatewayRig rig;
  rig.client.write(good_read(1));
  const auto job = rig.expect_request<cansync::ParameterRequest>();
  rig.client.write(TestClient::request<gateway_JobCancel>(1));
  EXPECT_EQ(rig.expect_request<Cancel>().id, job.id);
  cansync::ParameterResult result;
  result.outcome = Outcome::cancelled;
  rig.answer(ParameterDone{job.id, result});
  const auto reply = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_CANCELLED);
}

TEST(GatewayJobs, ACancelThatOvertookItsRequestStillCounts) {
  GatewayRig rig;
  rig.client.deliver(TestClient::request<gateway_JobCancel>(5));
  // The pass of the gateway that takes this command takes the cancel too.
  rig.client.write(control_word(1));
  rig.answer(CommandDone{rig.expect_request<cansync::ControlWordRequest>().id, Outcome::done});
  ASSERT_TRUE(rig.client.reply<cansync_CommandReply>(1));

  rig.client.write(good_read(5));
  const auto reply = rig.client.reply<cansync_ParameterReply>(5);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_CANCELLED);
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

TEST(GatewayJobs, StopAnswersEveryOpenRequest) {
  GatewayRig rig;
  for (std::uint64_t number = 1; number <= 5; ++number) rig.client.write(good_read(number));
  rig.client.write(upload_request(6, 100));
  rig.client.write(control_word(7));
  // The fifth read waits until the slave has one less.
  for (int i = 0; i < 6; ++i) ASSERT_TRUE(rig.next_request());
  rig.gateway->stop();
  for (std::uint64_t number = 1; number <= 5; ++number) {
    const auto reply = rig.client.reply<cansync_ParameterReply>(number);
    ASSERT_TRUE(reply) << number;
    EXPECT_EQ(reply->code, gateway_REPLY_MASTER_STOPPED);
    EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(number), 0u);
  }
  const auto transfer = rig.transfer_reply(6);
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->reply.code, gateway_REPLY_MASTER_STOPPED);
  const auto command = rig.client.reply<cansync_CommandReply>(7);
  ASSERT_TRUE(command);
  EXPECT_EQ(command->code, gateway_REPLY_MASTER_STOPPED);
}

TEST(GatewayJobs, ResultsLeftInTheExchangeAreToldWhenItStops) {
  GatewayRig rig;
  rig.client.write(good_read(1));
  rig.client.write(good_read(2));
  const auto first = rig.expect_request<cansync::ParameterRequest>();
  ASSERT_TRUE(rig.next_request());
  // Not signalled: only the last look of the gateway finds it.
  ASSERT_TRUE(rig.exchange.terminals.try_push(ParameterDone{first.id, {}}));
  rig.gateway->stop();
  const auto done = rig.client.reply<cansync_ParameterReply>(1);
  const auto stopped = rig.client.reply<cansync_ParameterReply>(2);
  ASSERT_TRUE(done && stopped);
  EXPECT_EQ(done->code, gateway_REPLY_DONE);
  EXPECT_EQ(stopped->code, gateway_REPLY_MASTER_STOPPED);
}

TEST(GatewayJobs, ManyClientsEachGetTheirOwnReplies) {
  GatewayRig rig;
  constexpr std::uint8_t kClients = 4;
  constexpr std::uint64_t kEach = 50;
  for (std::uint64_t number = 1; number <= kEach; ++number) {
    for (std::uint8_t client = 1; client <= kClients; ++client) {
      auto request = good_read(number, client);
      request.number = client * 100u + static_cast<std::uint32_t>(number);
      rig.client.write(request);
    }
  }
  for (std::uint64_t i = 0; i < kClients * kEach; ++i) {
    const auto job = rig.expect_request<cansync::ParameterRequest>();
    cansync::ParameterResult result;
    result.value = job.number.value();
    rig.answer(ParameterDone{job.id, result});
  }
  for (std::uint8_t client = 1; client <= kClients; ++client) {
    for (std::uint64_t number = 1; number <= kEach; ++number) {
      const auto reply = rig.client.reply<cansync_ParameterReply>(number, TestClient::identity(client));
      ASSERT_TRUE(reply);
      EXPECT_EQ(reply->value, std::uint64_t{client} * 100 + number);
      EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(number, TestClient::identity(client)), 0u);
    }
  }
}

}  // namespace
}  // namespace cansyncd
