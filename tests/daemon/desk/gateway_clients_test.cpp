#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <vector>

#include "good_requests.h"
#include "support/gateway_rig.h"

namespace cansyncd {
namespace {

using cansync::Outcome;

/// Another program on the same bus.
struct Other {
  explicit Other(GatewayRig& rig) : client(rig.places().there) { EXPECT_TRUE(client.wait_for_gateway()); }
  TestClient client;
};

std::optional<gateway_GatewayStatus> status_with(
    GatewayRig& rig, const std::function<bool(const gateway_GatewayStatus&)>& fits) {
  return rig.client.wait_for<gateway_GatewayStatus>(fits);
}

std::optional<gateway_Event> event(GatewayRig& rig, std::string_view code) {
  return rig.client.wait_for<gateway_Event>([&](const auto& e) { return std::string_view(e.code) == code; });
}

TEST(GatewayClients, WhoIsGoneHasItsRequestsCancelled) {
  GatewayRig rig;
  auto other = std::make_unique<Other>(rig);
  for (std::uint64_t number = 1; number <= 6; ++number) other->client.write(good_read(number, 2));
  std::vector<cansync::JobId> given;
  given.reserve(4);
  for (int i = 0; i < 4; ++i) given.push_back(rig.expect_request<cansync::ParameterRequest>().id);
  rig.client.write(good_read(1, 1, 2));
  const auto own = rig.expect_request<cansync::ParameterRequest>().id;
  other.reset();
  // What the master has is cancelled there; what waited never gets there. The client that lives keeps its
  // job.
  for (const auto id : given) EXPECT_EQ(rig.expect_request<Cancel>().id, id);
  for (const auto id : given) rig.answer(ParameterDone{id, {.outcome = Outcome::cancelled}});
  rig.answer(ParameterDone{own, {}});
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  for (std::uint64_t number = 1; number <= 6; ++number) {
    const auto reply = rig.client.reply<cansync_ParameterReply>(number, TestClient::identity(2));
    ASSERT_TRUE(reply) << number;
    EXPECT_EQ(reply->code, gateway_REPLY_CANCELLED);
    EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(number, TestClient::identity(2)), 0u);
  }
  const auto gone = event(rig, "client_gone");
  ASSERT_TRUE(gone);
  EXPECT_NE(std::string_view(gone->text).find("'tester' (02000000) is gone; its 6 open requests"),
            std::string_view::npos)
      << gone->text;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  // Nothing of it is kept.
  EXPECT_TRUE(status_with(rig, [](const auto& status) { return status.clients == 1; }));
}

TEST(GatewayClients, ATransferOfWhoIsGoneIsCancelledOnTheSlave) {
  GatewayRig rig;
  auto other = std::make_unique<Other>(rig);
  auto request = TestClient::request<cansync_TransferRequest>(1, TestClient::identity(2));
  request.slave = 1;
  request.address = 0x1000;
  request.length = 5000;
  other->client.write(request);
  const auto job = rig.expect_request<cansync::TransferRequest>();
  other.reset();
  EXPECT_EQ(rig.expect_request<Cancel>().id, job.id);
  // The data stays the realtime thread's until it has answered.
  std::fill(job.data.begin(), job.data.end(), std::uint8_t{1});
  rig.answer(TransferDone{job.id, {.outcome = Outcome::cancelled}});
  const auto answer = rig.transfer_reply(1);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->reply.code, gateway_REPLY_CANCELLED);
}

TEST(GatewayClients, ProgramsThatComeAndGoLeaveNothingBehind) {
  GatewayRig rig;
  for (std::uint8_t n = 10; n < 14; ++n) {
    Other other(rig);
    other.client.write(good_read(1, n));
    rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
    ASSERT_TRUE(other.client.reply<cansync_ParameterReply>(1, TestClient::identity(n)));
  }
  EXPECT_TRUE(status_with(rig, [](const auto& status) { return status.clients == 0; }));
  // Also readers of replies are told that these clients are no more.
  std::size_t left = 0;
  EXPECT_TRUE(eventually(rig.client.signal(),
                         [&] {
                           const auto& replies = rig.client.all<cansync_ParameterReply>();
                           left = static_cast<std::size_t>(
                               std::count_if(replies.begin(), replies.end(),
                                             [&](const auto& reply) { return rig.client.keeps_key(reply); }));
                           return replies.size() == 4 && left == 0;
                         }))
      << rig.client.all<cansync_ParameterReply>().size() << " replies, " << left << " clients known";
}

/// A program that counts everything that comes to the partition of its replies.
struct Counting {
  Counting(const gateway::dds::ParticipantOptions& options, std::uint8_t number)
      : participant(options),
        own{gateway::dds::reply_partition(options.partition, TestClient::identity(number))} {}

  /// Takes what has come.
  void take() {
    (void)parameters.take([&](const cansync_ParameterReply&) { ++samples; });
    (void)commands.take([&](const cansync_CommandReply&) { ++samples; });
    (void)progress.take([&](const cansync_TransferProgress&) { ++progress_samples; });
    (void)transfers.take([&](const cansync_TransferReply& reply) {
      ++samples;
      bytes += reply.data._length;
    });
  }
  bool everything_matched() const {
    return asks.matched() > 0 && uploads.matched() > 0 && parameters.matched() > 0 && transfers.matched() > 0;
  }

  gateway::dds::Participant participant;
  gateway::dds::Partitions own;
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<cansync_ParameterReply> parameters{participant, own, &signal};
  gateway::dds::Reader<cansync_TransferReply> transfers{participant, own, &signal};
  gateway::dds::Reader<cansync_TransferProgress> progress{participant, own, &signal};
  gateway::dds::Reader<cansync_CommandReply> commands{participant, own, &signal};
  gateway::dds::Writer<cansync_ParameterRequest> asks{participant, 0, &signal};
  gateway::dds::Writer<cansync_TransferRequest> uploads{participant, 0, &signal};
  std::size_t samples = 0;
  std::size_t progress_samples = 0;
  std::size_t bytes = 0;
};

TEST(GatewayClients, RepliesDataAndProgressReachTheClientThatAskedAndNobodyElse) {
  constexpr std::uint32_t kBytes = cansync_MAXIMUM_TRANSFER;
  GatewayRig rig;
  std::vector<std::unique_ptr<Counting>> clients;
  for (std::uint8_t number = 10; number < 42; ++number)
    clients.push_back(std::make_unique<Counting>(rig.places().there, number));
  const auto read_once = [&](std::uint64_t number) {
    for (std::size_t i = 0; i < clients.size(); ++i) {
      Counting& client = *clients[i];
      const std::size_t before = client.samples;
      ASSERT_EQ(client.asks.write(good_read(number, static_cast<std::uint8_t>(10 + i))), DDS_RETCODE_OK);
      rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
      ASSERT_TRUE(eventually(client.signal, [&] {
        client.take();
        return client.samples > before;
      }));
    }
  };
  for (const auto& client : clients)
    ASSERT_TRUE(eventually(client->signal, [&] { return client->everything_matched(); }));
  read_once(1);

  Counting& uploader = *clients.front();
  auto request = TestClient::request<cansync_TransferRequest>(2, TestClient::identity(10));
  request.slave = 2;
  request.address = 0x1000;
  request.length = kBytes;
  ASSERT_EQ(uploader.uploads.write(request), DDS_RETCODE_OK);
  const auto job = rig.expect_request<cansync::TransferRequest>();
  ASSERT_TRUE(eventually(uploader.signal, [&] {
    rig.report(TransferProgress{job.id, 300});
    uploader.take();
    return uploader.progress_samples > 0;
  }));
  cansync::TransferResult result;
  result.bytes = kBytes;
  rig.answer(TransferDone{job.id, result});
  ASSERT_TRUE(eventually(uploader.signal, [&] {
    uploader.take();
    return uploader.bytes == kBytes;
  }));

  // What is asked afterwards comes after everything else that was to come.
  read_once(3);
  EXPECT_EQ(uploader.samples, 3u);
  for (const auto& client : clients) {
    if (client.get() == &uploader) continue;
    client->take();
    EXPECT_EQ(client->samples, 2u) << "its own alone";
    EXPECT_EQ(client->bytes, 0u);
    EXPECT_EQ(client->progress_samples, 0u);
    EXPECT_EQ(client->transfers.matched(), 1u) << "no writer has anything for it";
  }
}

TEST(GatewayClients, AnotherProgramsIdentityIsNoKeyToItsJobs) {
  GatewayRig rig;
  rig.client.write(good_read(1));
  const auto job = rig.expect_request<cansync::ParameterRequest>();
  Other other(rig);
  other.client.deliver(TestClient::request<gateway_JobCancel>(1));
  other.client.deliver(good_read(2));
  EXPECT_TRUE(status_with(rig, [](const auto& status) { return status.rejected_identities == 2; }));
  const auto told = event(rig, "requests_rejected");
  ASSERT_TRUE(told);
  EXPECT_NE(std::string_view(told->text).find("another program"), std::string_view::npos) << told->text;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  rig.answer(ParameterDone{job.id, {}});
  const auto reply = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
  EXPECT_EQ(rig.client.replies<cansync_ParameterReply>(2), 0u);
  // The owner goes on using its numbers.
  rig.client.write(good_read(2));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  EXPECT_TRUE(rig.client.reply<cansync_ParameterReply>(2));
  // The other is served with an identity of its own.
  other.client.write(good_read(1, 7));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  EXPECT_TRUE(other.client.reply<cansync_ParameterReply>(1, TestClient::identity(7)));
}

TEST(GatewayClients, TheIdentityOfWhoIsGoneIsNotTakenBeforeItsRequestsHaveEndedAndAnotherOneIs) {
  GatewayRig rig;
  auto other = std::make_unique<Other>(rig);
  other->client.write(good_read(1, 2));
  const auto job = rig.expect_request<cansync::ParameterRequest>().id;
  other.reset();
  EXPECT_EQ(rig.expect_request<Cancel>().id, job);
  rig.client.write(good_read(2, 2));
  const auto refused = rig.client.reply<cansync_ParameterReply>(2, TestClient::identity(2));
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->cause, gateway_CAUSE_IDENTITY) << refused->reason;
  rig.client.write(good_read(2, 3));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  const auto served = rig.client.reply<cansync_ParameterReply>(2, TestClient::identity(3));
  ASSERT_TRUE(served);
  EXPECT_EQ(served->code, gateway_REPLY_DONE);
  rig.answer(ParameterDone{job, {.outcome = Outcome::cancelled}});
}

TEST(GatewayClients, AStaleRequestIsRefusedAndCounted) {
  GatewayRig rig;
  auto request = good_read(1);
  const dds_time_t now = dds_time();
  rig.client.write_at(request, now - DDS_SECS(60));
  const auto old = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(old);
  EXPECT_EQ(old->code, gateway_REPLY_REFUSED);
  EXPECT_EQ(std::string_view(old->reason).find("stale: written 6"), 0u) << old->reason;
  request.request = 2;
  rig.client.write_at(request, now + DDS_SECS(600));
  const auto future = rig.client.reply<cansync_ParameterReply>(2);
  ASSERT_TRUE(future);
  EXPECT_EQ(future->code, gateway_REPLY_REFUSED);
  EXPECT_EQ(std::string_view(future->reason).find("from the future"), 0u) << future->reason;
  EXPECT_EQ(rig.exchange.requests.size(), 0u);
  EXPECT_TRUE(status_with(rig, [](const auto& status) { return status.rejected_stale == 2; }));
}

TEST(GatewayClients, TheAgeOfARequestNeedNotBeLookedAt) {
  Config config = gateway_config();
  config.dds.request_max_age = std::chrono::milliseconds(0);
  GatewayRig rig(config);
  rig.client.write_at(good_read(1), dds_time() - DDS_SECS(60));
  rig.answer(ParameterDone{rig.expect_request<cansync::ParameterRequest>().id, {}});
  const auto reply = rig.client.reply<cansync_ParameterReply>(1);
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, gateway_REPLY_DONE);
}

TEST(GatewayClients, RejectionsAreCountedByKind) {
  GatewayRig rig;
  auto bad = good_read(1);
  bad.slave = 9;
  rig.client.write(bad);
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  rig.client.write(good_read(1));
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(1));
  rig.client.write(good_read(2));
  rig.answer(Refused{rig.expect_request<cansync::ParameterRequest>().id, cansync::Refusal::wrong_state});
  ASSERT_TRUE(rig.client.reply<cansync_ParameterReply>(2));
  for (std::uint64_t number = 3; number <= 70; ++number) rig.client.write(good_read(number));
  EXPECT_TRUE(status_with(rig, [](const auto& status) {
    return status.rejected_values == 1 && status.rejected_numbers == 1 && status.rejected_state == 1 &&
           status.rejected_full == 4;
  }));
}

}  // namespace
}  // namespace cansyncd
