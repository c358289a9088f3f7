#include <gtest/gtest.h>

#include <optional>

#include "good_requests.h"

namespace cansyncd {
namespace {

using cansync::Refusal;

TEST(GatewayRefusals, ANumberThatIsOpenIsNotExecutedTwice) {
  GatewayRig rig;
  rig.client.write(good_read(5));
  const auto job = rig.expect_request<cansync::ParameterRequest>();
  rig.client.write(good_read(5));
  const auto refused = rig.client.reply<cansync_ParameterReply>(5);
  ASSERT_TRUE(refused);
  expect_refused(*refused, gateway_CAUSE_NUMBER_USED, {"request 5", "open already"});
  // The numbers of all kinds of requests are one row.
  rig.client.write(good_command(5));
  const auto command = rig.client.reply<cansync_CommandReply>(5);
  ASSERT_TRUE(command);
  expect_refused(*command, gateway_CAUSE_NUMBER_USED, {"request 5", "open already"});
  EXPECT_EQ(rig.exchange.requests.size(), 0u);

  rig.answer(ParameterDone{job.id, {}});
  const auto done = rig.client.reply<cansync_ParameterReply>(5);
  ASSERT_TRUE(done);
  EXPECT_EQ(done->code, gateway_REPLY_DONE);
  EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(5), 0u);
  // Also when it is answered.
  rig.client.write(good_read(5));
  const auto again = rig.client.reply<cansync_ParameterReply>(5);
  ASSERT_TRUE(again);
  expect_refused(*again, gateway_CAUSE_NUMBER_USED, {"request 5", "used already", "highest, 5"});
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
}

TEST(GatewayRefusals, AClientHasALimitThatLeavesRoomForOthers) {
  GatewayRig rig;
  for (std::uint64_t number = 1; number <= JobBook::kPerClient; ++number) rig.client.write(good_read(number));
  rig.client.write(good_read(100));
  const auto refused = rig.client.reply<cansync_ParameterReply>(100);
  ASSERT_TRUE(refused);
  expect_refused(*refused, gateway_CAUSE_CLIENT_LIMIT, {"queue full", "64 requests", "at most 64"});
  // Another client has its own, and its turn: behind the four the slave has, not behind all 64.
  rig.client.deliver(good_read(1, 2));
  // What is refused behind it tells that it has been taken, too.
  auto wrong = good_read(2, 2);
  wrong.slave = 99;
  rig.client.write(wrong);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(2, TestClient::identity(2)));
  std::vector<cansync::JobId> jobs;
  for (unsigned i = 0; i < 4; ++i) jobs.push_back(rig.expect_request<cansync::ParameterRequest>().id);
  cansync::JobId other = 0;
  for (unsigned i = 0; i < 2; ++i) {
    rig.answer(ParameterDone{jobs[i], {}});
    other = rig.expect_request<cansync::ParameterRequest>().id;
    rig.answer(ParameterDone{other, {}});
    if (rig.client.replies<cansync_ParameterReply>(1, TestClient::identity(2)) > 0) break;
  }
  EXPECT_TRUE(rig.client.reply<cansync_ParameterReply>(1, TestClient::identity(2)));
  // A reply makes room for one request.
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  rig.client.deliver(good_read(101));
  rig.client.write(TestClient::request<gateway_JobCancel>(101));
  const auto cancelled = rig.client.reply<cansync_ParameterReply>(101);
  ASSERT_TRUE(cancelled);
  EXPECT_EQ(cancelled->code, gateway_REPLY_CANCELLED) << cancelled->reason;
}

/// A request as a program made for data model 6 writes it.
template <class T>
T without_daemon(T request) {
  gateway::dds::set_daemon({}, request);
  return request;
}

TEST(GatewayRefusals, AProgramOfAnOlderDataModelIsToldSo) {
  GatewayRig rig;
  rig.client.write(without_daemon(good_read(1)));
  rig.client.write(without_daemon(good_upload(2)));
  rig.client.write(without_daemon(good_command(3)));
  const auto expect_told = [](const auto& reply) {
    ASSERT_TRUE(reply);
    expect_refused(*reply, gateway_CAUSE_OTHER_DAEMON,
                   {"names none", "data model 6 or older", "GatewayStatus.daemon"});
  };
  expect_told(rig.client.reply<cansync_ParameterReply>(1));
  expect_told(rig.client.reply<cansync_CommandReply>(3));
  const auto transfer = rig.transfer_reply(2);
  ASSERT_TRUE(transfer);
  expect_told(std::optional(transfer->reply));
  Request nothing;
  EXPECT_FALSE(rig.exchange.requests.try_pop(nothing));
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>(
      [](const auto& status) { return status.rejected_other_daemon == 3; }));
}

TEST(GatewayRefusals, WhatIsMeantForAnotherDaemonIsNotAnswered) {
  GatewayRig rig;
  auto read = good_read(1);
  gateway::dds::set_daemon({0xDA, 0xE0, 0x02}, read);
  rig.client.deliver(read);
  rig.client.write(good_read(2));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  EXPECT_TRUE(rig.client.reply<cansync_ParameterReply>(2));
  EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(1), 0u);
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>(
      [](const auto& status) { return status.rejected_other_daemon == 1; }));
}

TEST(GatewayRefusals, ARequestWaitsWhenTheWayToTheRealtimeThreadIsFull) {
  ExchangeSizes sizes;
  sizes.requests = 2;
  GatewayRig rig(gateway_config(), sizes);
  for (std::uint64_t number = 1; number <= 4; ++number) rig.client.write(good_read(number));
  for (std::uint64_t number = 1; number <= 4; ++number) {
    rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
    const auto reply = rig.client.reply<cansync_ParameterReply>(number);
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, gateway_REPLY_DONE);
  }
}

TEST(GatewayRefusals, TransfersHaveALimitOfAClientAndOneOfAll) {
  GatewayRig rig;
  const auto ask = [&](std::uint64_t number, std::uint8_t client) {
    auto request = good_upload(number);
    request.client[0] = client;
    request.length = 16u << 20;
    rig.client.write(request);
  };
  for (std::uint64_t number = 1; number <= 3; ++number) ask(number, 1);
  const auto own = rig.transfer_reply(3);
  ASSERT_TRUE(own);
  expect_refused(own->reply, gateway_CAUSE_CLIENT_LIMIT,
                 {"length 16777216", "of this client have 33554432 bytes, at most 33554432"});
  // After a reply the client has room again, and so have all.
  const auto is_done = [&](std::uint64_t number) {
    rig.answer(TransferDone{rig.expect_request<cansync::TransferRequest>().id, {}});
    const auto reply = rig.transfer_reply(number);
    return reply && reply->reply.code == gateway_REPLY_DONE;
  };
  EXPECT_TRUE(is_done(1));
  ask(4, 1);
  EXPECT_TRUE(is_done(2));
  EXPECT_TRUE(is_done(4));
  for (std::uint64_t number = 5; number <= 6; ++number) ask(number, 1);
  for (std::uint64_t number = 10; number < 16; ++number) ask(number, static_cast<std::uint8_t>(number / 2));
  ask(20, 9);
  const auto all = rig.transfer_reply(20);
  ASSERT_TRUE(all);
  expect_refused(all->reply, gateway_CAUSE_SHARED_LIMIT,
                 {"length 16777216", "134217728 bytes, at most 134217728"});
  EXPECT_TRUE(is_done(5));
  ask(21, 9);
  for (int open = 0; open < 8; ++open)
    rig.answer(TransferDone{rig.expect_request<cansync::TransferRequest>().id, {}});
  const auto later = rig.transfer_reply(21);
  ASSERT_TRUE(later);
  EXPECT_EQ(later->reply.code, gateway_REPLY_DONE);
}

/// What only the master knows comes back as a number and leaves with field, value, range and remedy.
TEST(GatewayRefusals, OfTheMasterAreExplained) {
  GatewayRig rig;
  MasterSnapshot master;
  master.state = cansync::State::waiting_for_start;
  master.configured = {0xF};
  master.synchronized = {0x5};
  master.released = {0x5};
  rig.tell(master);
  rig.client.write(good_read(1));
  rig.answer(Refused{rig.expect_request<cansync::ParameterRequest>().id, Refusal::wrong_state});
  const auto state = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(state);
  expect_refused(*state, gateway_CAUSE_WRONG_STATE, {"in stop", "0x0003", "0x0043", "mode setup"});

  rig.client.write(good_read(2));
  rig.answer(Refused{rig.expect_request<cansync::ParameterRequest>().id, Refusal::queue_full});
  const auto queue = rig.client.reply<cansync_ParameterReply>(2);
  ASSERT_TRUE(queue);
  expect_refused(*queue, gateway_CAUSE_QUEUE_FULL, {"queue full", "256 parameter jobs", "at most 256"});

  auto mode = good_command(3, cansync_COMMAND_MODE);
  mode.mode = cansync_MODE_RUN;
  rig.client.write(mode);
  rig.answer(Refused{rig.expect_request<ModeRequest>().id, Refusal::slaves_missing});
  const auto missing = rig.client.reply<cansync_CommandReply>(3);
  ASSERT_TRUE(missing);
  expect_refused(*missing, gateway_CAUSE_SLAVES_MISSING, {"slave 1 'feeder', slave 3 'rewinder'", "force"});

  auto control = good_command(4, cansync_COMMAND_CONTROL_WORD);
  control.slave = 1;
  rig.client.write(control);
  rig.answer(Refused{rig.expect_request<cansync::ControlWordRequest>().id, Refusal::slave_held});
  const auto held = rig.client.reply<cansync_CommandReply>(4);
  ASSERT_TRUE(held);
  expect_refused(*held, gateway_CAUSE_SLAVE_HELD,
                 {"slave 1 'feeder'", "held out", "0x000F", "cansync release"});

  rig.client.write(good_read(5));
  rig.answer(Refused{rig.expect_request<cansync::ParameterRequest>().id, Refusal::slave_lost});
  const auto lost = rig.client.reply<cansync_ParameterReply>(5);
  ASSERT_TRUE(lost);
  expect_refused(*lost, gateway_CAUSE_SLAVE_LOST, {"slave ", "does not answer", "bus cable"});

  rig.client.write(good_upload(6));
  rig.answer(Refused{rig.expect_request<cansync::TransferRequest>().id, Refusal::queue_full});
  const auto transfer = rig.transfer_reply(6);
  ASSERT_TRUE(transfer);
  expect_refused(transfer->reply, gateway_CAUSE_QUEUE_FULL, {"32 transfers", "at most 32"});

  rig.client.write(good_command(7, cansync_COMMAND_BROADCAST));
  rig.answer(Refused{rig.expect_request<cansync::BroadcastRequest>().id, Refusal::queue_full});
  const auto broadcast = rig.client.reply<cansync_CommandReply>(7);
  ASSERT_TRUE(broadcast);
  expect_refused(*broadcast, gateway_CAUSE_QUEUE_FULL, {"8 broadcasts of priority 1", "at most 8"});
}

}  // namespace
}  // namespace cansyncd
