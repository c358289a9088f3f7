#include <cansync/client.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <future>
#include <iterator>
#include <string>
#include <thread>

#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

/// The ways to wait: for a state, with a callback, with a future; and who an error comes from.
namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class WaitingTest : public ::testing::Test {
 protected:
  Options options() const {
    return {.domain = places.there.domain,
            .bus = places.there.partition,
            .client_name = "waiting",
            .xml = places.there.xml,
            .wait = gateway::kLongWait};
  }
  TwoPlaces places;
  std::optional<FakeDaemon> daemon{std::in_place, places.here};
  std::optional<Client> client{Client::connect(options())};
};

TEST_F(WaitingTest, ForAStateThatIsThereAndOneThatNeverComes) {
  const auto active =
      client->wait_status([](const MasterStatus& s) { return s.option_status == 0x80; }, gateway::kLongWait);
  ASSERT_TRUE(active);
  EXPECT_EQ(text(client->gateway_status().bus), places.here.partition);
  EXPECT_TRUE(
      std::equal(std::begin(active->daemon), std::end(active->daemon), client->gateway_status().daemon));
  EXPECT_FALSE(
      client->wait_status([](const MasterStatus& s) { return s.option_status == 0x43; }, milliseconds(20)));
}

TEST_F(WaitingTest, AConditionMayAskTheClient) {
  const auto active = client->wait_status(
      [&](const MasterStatus& s) {
        return client->slaves().size() == 4 && client->validity().daemon[0] == s.daemon[0] &&
               client->read(1, 7).ok();
      },
      gateway::kLongWait);
  EXPECT_TRUE(active);
}

TEST_F(WaitingTest, TimingOfADaemonThatIsGoneGreetsNobody) {
  const auto repeat_until = [](const auto& tell, const auto& heard) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    while (!heard() && std::chrono::steady_clock::now() < end) {
      tell();
      std::this_thread::sleep_for(milliseconds(1));
    }
    return heard();
  };
  std::atomic<int> timings = 0;
  const auto count = [&](const Timing& /*timing*/) { ++timings; };
  {
    const Subscription subscription = client->on_timing(count);
    ASSERT_TRUE(repeat_until([&] { daemon->publish_rest(); }, [&] { return timings != 0; }));
  }
  daemon.reset();
  daemon.emplace(places.here);
  ASSERT_TRUE(
      client->wait_status([](const MasterStatus& s) { return s.option_status == 0x80; }, gateway::kLongWait));
  timings = 0;
  const Subscription subscription = client->on_timing(count);
  // Subscribers are told of all topics in one turn: after the second turn the first is over.
  std::atomic<int> turns = 0;
  const Subscription statuses = client->on_master_status([&](const MasterStatus& /*status*/) { ++turns; });
  ASSERT_TRUE(repeat_until([&] { daemon->tell(); }, [&] { return turns >= 3; }));
  EXPECT_EQ(timings, 0);
}

TEST_F(WaitingTest, WhatADaemonThatIsGoneToldLastIsNotHowTheLineIs) {
  const auto is_active = [](const MasterStatus& status) { return status.option_status == 0x80; };
  ASSERT_TRUE(client->wait_status(is_active, gateway::kLongWait));
  ASSERT_EQ(client->slaves().size(), 4u);
  EXPECT_EQ(client->find_slave("slave2").slave, 2);
  EXPECT_EQ(client->bus_status().bit_rate, 1'000'000u);
  daemon.reset();
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  while (client->daemon_present() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_FALSE(client->wait_status(is_active, milliseconds(50)));
  // Nobody tells anything, which is known at once.
  const auto before = std::chrono::steady_clock::now();
  EXPECT_THROW((void)client->master_status(), NoDaemon);
  EXPECT_THROW((void)client->gateway_status(), NoDaemon);
  EXPECT_THROW((void)client->bus_status(), NoDaemon);
  EXPECT_THROW((void)client->slaves(), NoDaemon);
  EXPECT_THROW((void)client->find_slave("slave2"), NoDaemon);
  EXPECT_LT(std::chrono::steady_clock::now() - before, seconds(2))
      << "one wait alone would have been as long";
  EXPECT_FALSE(client->master_status(milliseconds(0)));
  EXPECT_FALSE(client->gateway_status(milliseconds(0)));
  EXPECT_FALSE(client->bus_status(milliseconds(0)));
  EXPECT_FALSE(client->actual_values(2, milliseconds(0)));
  daemon.emplace(places.here);
  EXPECT_TRUE(client->wait_status(is_active, gateway::kLongWait)) << "and that of the new one is";
  EXPECT_EQ(client->slaves(gateway::kLongWait).size(), 4u);
  EXPECT_EQ(client->master_status().option_status, 0x80);
  EXPECT_EQ(text(client->gateway_status().bus), places.here.partition);
}

TEST_F(WaitingTest, EventsThatNeverRestAreCollectedForTwoSecondsAndOfEachSeverityTheLast) {
  (void)client->recent_events();  // reads them from now on
  daemon->publish_event(1, gateway_SEVERITY_ERROR);
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    for (std::uint64_t number = 2; !stop; ++number) {
      daemon->publish_event(number, gateway_SEVERITY_INFO);
      std::this_thread::sleep_for(milliseconds(2));
    }
  });
  const auto before = std::chrono::steady_clock::now();
  const std::vector<Event> recent = client->recent_events();
  const auto took = std::chrono::steady_clock::now() - before;
  stop = true;
  writer.join();
  EXPECT_GE(took, seconds(2));
  EXPECT_LT(took, gateway::kLongWait);
  EXPECT_EQ(recent.size(), 101u);
  EXPECT_EQ(recent.front().number, 1u) << "what is frequent does not push faults out";
}

TEST_F(WaitingTest, AClientThatOnlyLooksAsksForNothing) {
  Options looking = options();
  looking.requests = false;
  Client onlooker = Client::connect(looking);
  EXPECT_EQ(text(onlooker.gateway_status().protocol), "cansync-master");
  EXPECT_EQ(onlooker.bus_status().bit_rate, 1'000'000u);
  EXPECT_EQ(onlooker.master_status().option_status, 0x80);
  EXPECT_EQ(onlooker.slaves().size(), 4u);
  const std::size_t asked = daemon->requests();
  const ParameterReply reply = onlooker.read(1, 7);
  EXPECT_EQ(reply.code, ReplyCode::refused);
  EXPECT_EQ(reply.cause, RefusalCause::right);
  EXPECT_NE(reply.reason.find("Options::requests"), std::string::npos) << reply.reason;
  EXPECT_EQ(onlooker.control_word(1, 0).wait().code, ReplyCode::refused);
  EXPECT_EQ(daemon->requests(), asked);
  EXPECT_THROW(static_cast<void>(onlooker.realtime_status()), NoDaemon) << "this daemon tells none";
}

TEST_F(WaitingTest, CallbackIsCalledOnceWhenTheReplyComesAndAtOnceAfterwards) {
  std::promise<ParameterReply> told;
  const ParameterJob job = client->submit(ParameterRequest{.slave = 1, .number = FakeDaemon::kSilentNumber});
  int calls = 0;
  job.then([&](const ParameterReply& reply) {
    ++calls;
    told.set_value(reply);
  });
  EXPECT_EQ(job.wait_for(milliseconds(0)), std::nullopt);
  ASSERT_TRUE(job.cancel());
  EXPECT_EQ(told.get_future().get().code, ReplyCode::cancelled);
  EXPECT_EQ(calls, 1);
  bool at_once = false;
  job.then([&](const ParameterReply& reply) { at_once = reply.code == ReplyCode::cancelled; });
  EXPECT_TRUE(at_once);
}

TEST_F(WaitingTest, FuturesOfEveryKindOfJob) {
  std::future<ParameterReply> read = client->submit(ParameterRequest{.slave = 1, .number = 7}).future();
  std::future<TransferReply> up =
      client->submit(TransferRequest{.slave = 1, .address = 0x100, .length = 10}).future();
  std::future<CommandReply> word = client->control_word(1, 3).future();
  EXPECT_TRUE(read.get().ok());
  EXPECT_EQ(up.get().data.size(), 10u);
  EXPECT_TRUE(word.get().ok());
}

TEST_F(WaitingTest, AClientThatGoesEndsItsFutures) {
  std::future<ParameterReply> silent =
      client->submit(ParameterRequest{.slave = 1, .number = FakeDaemon::kSilentNumber}).future();
  client.reset();
  const ParameterReply reply = silent.get();
  EXPECT_EQ(reply.code, ReplyCode::no_reply);
  EXPECT_EQ(reply.speaker, Speaker::nobody);
}

TEST_F(WaitingTest, ErrorsSayWhoRefused) {
  EXPECT_EQ(describe(client->read(1, 7)), "");
  EXPECT_EQ(describe(client->read(1, 4096)), "daemon: number 4096: out of range; allowed 0..4095");
  EXPECT_EQ(client->read(1, FakeDaemon::kErrorNumber).speaker, Speaker::slave);
  const TransferReply longest = client->download(1, 0x100, std::vector<std::uint8_t>(16'777'217));
  EXPECT_EQ(longest.speaker, Speaker::client);
  daemon.reset();
  ParameterReply gone;
  do {
    gone = client->read(1, 7);
  } while (gone.reason.find("nothing was sent") == std::string::npos);
  EXPECT_EQ(describe(gone).rfind("nobody there: ", 0), 0u) << describe(gone);
}

}  // namespace
}  // namespace cansync::client
