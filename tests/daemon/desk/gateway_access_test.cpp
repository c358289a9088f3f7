#include <gtest/gtest.h>

#include <set>
#include <string_view>
#include <variant>

#include "access_requests.h"
#include "daemon/cansync/requests/access.h"
#include "support/gateway_rig.h"

/// Who may change what.
namespace cansyncd {
namespace {

Config read_only_config() {
  Config config = gateway_config();
  config.access.read_only = true;
  return config;
}

// --- rights

/// Every kind of request, told apart: one alternative of the variant that is missing fails the count.
TEST(Access, EveryKindOfRequestHasItsRight) {
  cansync::ParameterRequest read;
  cansync::ParameterRequest write;
  write.write = true;
  cansync::TransferRequest up;
  up.direction = cansync::TransferRequest::Direction::upload;
  cansync::TransferRequest down;
  down.direction = cansync::TransferRequest::Direction::download;
  struct Case {
    Request request;
    Right right;
    bool changes;
  };
  const Case cases[] = {
      {read, Right::engineer, false},
      {write, Right::engineer, true},
      {up, Right::engineer, false},
      {down, Right::engineer, true},
      {cansync::ControlWordRequest{}, Right::operate, true},
      {cansync::BroadcastRequest{}, Right::operate, true},
      {cansync::ReferenceUpdate{}, Right::operate, true},
      {Cancel{}, Right::operate, false},
      {StopRelease{}, Right::operate, false},
      {ModeRequest{}, Right::engineer, true},
      {SetPolling{}, Right::engineer, true},
      {SetCursors{}, Right::engineer, true},
      {SetReferenceMapping{}, Right::engineer, true},
      {SetActualMapping{}, Right::engineer, true},
      {SetReferenceLimits{}, Right::engineer, true},
      {ReleaseSlave{}, Right::engineer, true},
  };
  Config open = gateway_config();
  const Config closed = read_only_config();
  std::set<std::size_t> kinds;
  for (const Case& c : cases) {
    kinds.insert(c.request.index());
    EXPECT_EQ(needed_right(c.request), c.right) << c.request.index();
    EXPECT_EQ(changes_something(c.request), c.changes) << c.request.index();
    EXPECT_FALSE(read_only_refusal(c.request, open));
    EXPECT_EQ(read_only_refusal(c.request, closed).has_value(), c.changes) << c.request.index();
  }
  EXPECT_EQ(kinds.size(), std::variant_size_v<Request>);
}

TEST(Access, WhatATopicGivesNoRightToIsRefusedAsSuch) {
  const auto refused = right_refusal(ModeRequest{}, Right::operate);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->cause, gateway_CAUSE_RIGHT);
  EXPECT_FALSE(right_refusal(ModeRequest{}, Right::engineer));
  EXPECT_FALSE(right_refusal(cansync::ControlWordRequest{}, Right::operate));
}

// --- read-only

TEST(ReadOnly, WritesDownloadsAndEveryCommandAreRefusedAndReadsAndUploadsGoOn) {
  GatewayRig rig(read_only_config());
  rig.tell(in_operation());
  std::uint64_t number = 1;
  const auto expect_refused = [](const auto& reply) {
    ASSERT_TRUE(reply);
    EXPECT_EQ(reply->code, gateway_REPLY_REFUSED);
    EXPECT_EQ(reply->cause, gateway_CAUSE_READ_ONLY);
    EXPECT_NE(std::string_view(reply->reason).find("access.read_only"), std::string_view::npos);
  };
  rig.client.write(parameter(number, true, 5));
  expect_refused(rig.client.reply<cansync_ParameterReply>(number++));
  rig.client.write(download(number));
  const auto transfer = rig.transfer_reply(number++);
  ASSERT_TRUE(transfer);
  EXPECT_EQ(transfer->reply.code, gateway_REPLY_REFUSED);
  for (const auto kind : kCommands) {
    rig.client.write(command(number, kind));
    expect_refused(rig.client.reply<cansync_CommandReply>(number++));
  }
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  EXPECT_EQ(rig.journal.wait_for("EVENT", "request_refused", number - 1).size(), number - 1)
      << "each refusal has its entry";

  rig.client.write(parameter(number, false));
  const auto read = rig.expect_request<cansync::ParameterRequest>();
  EXPECT_FALSE(read.write);
  rig.answer(ParameterDone{read.id, {.value = 7}});
  const auto answered = rig.client.reply<cansync_ParameterReply>(number++);
  ASSERT_TRUE(answered);
  EXPECT_EQ(answered->code, gateway_REPLY_DONE);
  rig.client.write(upload(number));
  const auto up = rig.expect_request<cansync::TransferRequest>();
  rig.answer(TransferDone{up.id, {.bytes = 4}});
  const auto uploaded = rig.transfer_reply(number);
  ASSERT_TRUE(uploaded);
  EXPECT_EQ(uploaded->reply.code, gateway_REPLY_DONE);
}

cansync_ReferenceValues reference_values(std::uint8_t telegram) {
  cansync_ReferenceValues sample = {};
  sample.telegram = telegram;
  sample.valid = 1;
  sample.release_intervals = 1000;
  std::copy(kTestDaemon.begin(), kTestDaemon.end(), std::begin(sample.daemon));
  sample.mapping_number = 1;
  return sample;
}

TEST(ReadOnly, ReferenceValuesAreRefusedWithOneEventAndStatusTellsWhy) {
  GatewayRig rig(read_only_config());
  gateway::dds::DataSignal signal;
  gateway::dds::Writer<cansync_ReferenceValues> writer(rig.client.participant(), 0, &signal);
  ASSERT_TRUE(eventually(signal, [&] { return writer.matched() > 0; }));
  ASSERT_EQ(writer.write(reference_values(1)), DDS_RETCODE_OK);
  const auto refused = rig.client.wait_for<gateway_Event>(
      [](const auto& e) { return std::string_view(e.code) == "reference_refused"; });
  ASSERT_TRUE(refused);
  EXPECT_NE(std::string_view(refused->text).find("access.read_only"), std::string_view::npos);
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>([](const auto& s) { return s.read_only; }));
}

TEST(ReadOnly, SwitchedOnByReloadItWithdrawsReferenceValuesAndSwitchedOffItTakesRequestsAgain) {
  GatewayRig rig;
  rig.gateway->reload(read_only_config());
  // Both telegrams: values given before could be released for hours.
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, cansync::Channel::one);
  EXPECT_EQ(rig.expect_request<StopRelease>().channel, cansync::Channel::two);
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>([](const auto& s) { return s.read_only; }));
  rig.client.write(parameter(1, true));
  const auto refused = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, gateway_REPLY_REFUSED);

  rig.client.all<gateway_GatewayStatus>().clear();
  rig.gateway->reload(gateway_config());
  EXPECT_TRUE(rig.client.wait_for<gateway_GatewayStatus>([](const auto& s) { return !s.read_only; }));
  rig.client.write(parameter(2, true));
  EXPECT_TRUE(rig.expect_request<cansync::ParameterRequest>().write);
}

}  // namespace
}  // namespace cansyncd
