#include <cansync/client.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "client/client_rig.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

/// Every request ends within its monitoring time and the grace, whatever becomes of its reply.
namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Clock = std::chrono::steady_clock;

/// A client whose requests end soon.
class ImpatientClient : public ::testing::Test {
 protected:
  static Options impatient(const TwoPlaces& places) {
    Options options = options_for(places.there);
    options.grace = milliseconds(600);
    return options;
  }
  TwoPlaces places_;
  FakeDaemon daemon_{places_.here};
  Client client_{Client::connect(impatient(places_))};
};

TEST_F(ImpatientClient, ARequestThatNothingIsHeardOfEndsByItself) {
  const ParameterJob lost =
      client_.submit(ParameterRequest{.slave = 1, .number = FakeDaemon::kLostNumber, .timeout_ms = 50});
  Watched<std::optional<ParameterReply>> told;
  lost.then([&](const ParameterReply& reply) { told.change([&](auto& value) { value = reply; }); });
  EXPECT_TRUE(told.wait([](const auto& value) { return value.has_value(); }));
  const ParameterReply reply = lost.wait();
  EXPECT_EQ(reply.code, ReplyCode::no_reply);
  EXPECT_EQ(reply.reason,
            "the daemon gave no reply within 650 ms (monitoring time 50 ms and 600 ms of grace); whether the "
            "request was done is not known");
  // It was to be cancelled before, so that it is not done later; and what comes now is nobody's.
  while (daemon_.cancels_in_vain() == 0) std::this_thread::yield();
  daemon_.answer_lost();
  EXPECT_TRUE(client_.read(0, 1).ok());
  EXPECT_EQ(lost.wait().code, ReplyCode::no_reply);
}

TEST_F(ImpatientClient, ARequestThatComesNotToItsTurnIsCancelledAndSaysSo) {
  const ParameterReply reply = client_.read(1, FakeDaemon::kSilentNumber, 50);
  EXPECT_EQ(reply.code, ReplyCode::timeout);
  EXPECT_EQ(reply.speaker, Speaker::client);
  EXPECT_EQ(reply.reason,
            "no reply within 350 ms (monitoring time 50 ms): the line has too much to do; the request was "
            "cancelled");
}

TEST_F(ImpatientClient, EveryKindOfRequestEndsWhenTheDaemonAnswersNothing) {
  daemon_.answer_nothing();
  const auto begun = Clock::now();
  const std::vector<ParameterJob> parameters = {
      client_.submit(ParameterRequest{.slave = 1, .number = 1, .timeout_ms = 50}),
      client_.submit(ParameterRequest{.write = true, .slave = 1, .number = 1, .timeout_ms = 50})};
  const std::vector<TransferJob> transfers = {
      client_.submit(TransferRequest{.slave = 1, .address = 0x100, .length = 10, .timeout_ms = 50}),
      client_.submit(TransferRequest{
          .download = true, .slave = 1, .address = 0x100, .data = {1, 2, 3}, .timeout_ms = 50})};
  const std::vector<CommandJob> commands = {client_.broadcast({.slave_mask = 1, .action = 130}),
                                            client_.mode(Mode::run),
                                            client_.release(1),
                                            client_.polling({.one = 1}),
                                            client_.cursors({.transfer = 1}),
                                            client_.map_references({0x01}),
                                            client_.map_actuals(1, {0x01}),
                                            client_.control_word(1, 7, 50)};  // 5 s at least
  const CommandJob longer = client_.control_word(2, 7, 5500);

  const auto expect_lost = [&](const auto& job, milliseconds monitoring, const std::string& told) {
    constexpr milliseconds kGiven(600);
    constexpr seconds kSlack(5);  // of a machine that has much to do
    const auto reply =
        job.wait_for(std::chrono::duration_cast<milliseconds>(begun + gateway::kLongWait - Clock::now()));
    const auto after = Clock::now() - begun;
    ASSERT_TRUE(reply.has_value()) << "is open still";
    EXPECT_EQ(reply->code, ReplyCode::no_reply);
    EXPECT_EQ(reply->speaker, Speaker::nobody);
    EXPECT_EQ(reply->reason, "the daemon gave no reply within " + told +
                                 " and 600 ms of grace); whether the request was done is not known");
    EXPECT_GE(after, monitoring + kGiven);
    EXPECT_LT(after, monitoring + kGiven + kSlack);
  };
  for (const ParameterJob& job : parameters)
    expect_lost(job, milliseconds(50), "650 ms (monitoring time 50 ms");
  for (const TransferJob& job : transfers)
    expect_lost(job, milliseconds(50), "650 ms (monitoring time 50 ms");
  for (const CommandJob& job : commands) expect_lost(job, milliseconds(5000), "5.6 s (monitoring time 5 s");
  expect_lost(longer, milliseconds(5500), "6.1 s (monitoring time 5.5 s");
  // Each was to be cancelled before.
  while (daemon_.cancels_in_vain() < daemon_.requests()) std::this_thread::yield();
}

TEST_F(ImpatientClient, ATransferThatStandsStillIsCancelledAndSaysSo) {
  const TransferJob up = client_.submit(
      TransferRequest{.slave = 1, .address = FakeDaemon::kEndlessAddress, .length = 100, .timeout_ms = 50});
  const TransferJob down = client_.submit(TransferRequest{.download = true,
                                                          .slave = 1,
                                                          .address = FakeDaemon::kEndlessAddress,
                                                          .data = {1, 2, 3},
                                                          .timeout_ms = 50});
  for (const TransferJob& job : {up, down}) {
    const std::optional<TransferReply> reply = job.wait_for(gateway::kLongWait);
    ASSERT_TRUE(reply.has_value()) << "is open still";
    EXPECT_EQ(reply->code, ReplyCode::timeout);
    EXPECT_EQ(reply->speaker, Speaker::client);
    EXPECT_EQ(reply->reason,
              "no reply within 350 ms (monitoring time 50 ms): the line has too much to do; the request was "
              "cancelled");
  }
}

TEST_F(ImpatientClient, ACommandThatIsNotSentIsCancelledAndSaysSo) {
  const std::optional<CommandReply> reply =
      client_.broadcast({.slave_mask = 1, .action = FakeDaemon::kSilentAction}).wait_for(gateway::kLongWait);
  ASSERT_TRUE(reply.has_value()) << "is open still";
  EXPECT_EQ(reply->code, ReplyCode::timeout);
  EXPECT_EQ(reply->speaker, Speaker::client);
  EXPECT_EQ(reply->reason,
            "no reply within 5.3 s (monitoring time 5 s): the line has too much to do; the request was "
            "cancelled");
}

/// Its receiver thread stands in a callback for as long as this object lives.
class StandingReceiver {
 public:
  StandingReceiver(Client& client, FakeDaemon& daemon)
      : subscription_(client.on_actual_values([this](const ActualValues& /*values*/) {
          stands_.change([](bool& value) { value = true; });
          go_on_.get_future().wait();
        })) {
    daemon.publish_actual(1, 1);
    EXPECT_TRUE(stands_.wait([](bool value) { return value; }));
  }
  ~StandingReceiver() { go_on_.set_value(); }
  StandingReceiver(const StandingReceiver&) = delete;
  StandingReceiver& operator=(const StandingReceiver&) = delete;

 private:
  std::promise<void> go_on_;
  Watched<bool> stands_;
  Subscription subscription_;
};

TEST_F(ImpatientClient, WaitEndsAlsoWhileTheReceiverStandsInACallback) {
  const StandingReceiver stands(client_, daemon_);
  EXPECT_EQ(client_.read(0, 1, 1).code, ReplyCode::no_reply);
}

TEST_F(ImpatientClient, WaitForATransferOrCommandEndsLikewise) {
  std::optional<StandingReceiver> stands(std::in_place, client_, daemon_);
  const std::atomic<bool> never = false;
  auto transfer = std::async(std::launch::async, [&] {
    return client_.submit(TransferRequest{.slave = 1, .address = 0x100, .length = 10, .timeout_ms = 1})
        .wait(never);
  });
  auto command = std::async(std::launch::async, [&] { return client_.mode(Mode::run).wait(); });
  EXPECT_EQ(transfer.wait_for(gateway::kLongWait), std::future_status::ready);
  EXPECT_EQ(command.wait_for(gateway::kLongWait), std::future_status::ready);
  stands.reset();  // whoever waits still is let go
  EXPECT_EQ(transfer.get().code, ReplyCode::no_reply);
  EXPECT_EQ(command.get().code, ReplyCode::no_reply);
}

}  // namespace
}  // namespace cansync::client
