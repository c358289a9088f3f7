#include <cansync/client.h>
#include <cansync/topics.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <string>
#include <thread>

#include "client/client_rig.h"
#include "client/fake_daemon.h"
#include "support/dds_places.h"
#include "support/long_wait.h"

/// Requests are for one start of the daemon, and the program knows which.
namespace cansync::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

class OneDaemon : public ::testing::Test {
 protected:
  /// Waits until the client has taken, and thought about, the status of `daemon`.
  void wait_until_known(FakeDaemon& daemon) {
    Watched<int> told;
    const Subscription statuses = client_.on_gateway_status([&](const GatewayStatus& status) {
      if (gateway::dds::daemon_of(status) == daemon.identity()) told.change([](int& count) { ++count; });
    });
    // With the second the pass that took the first is over.
    for (int wanted : {1, 2}) {
      daemon.tell();
      ASSERT_TRUE(told.wait([&](int count) { return count >= wanted; }));
    }
  }
  /// Asks until the reply fits; the last one.
  template <class Fits>
  ParameterReply read_until(Fits&& fits) {
    const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
    ParameterReply reply = client_.read(0, 1);
    while (!fits(reply) && std::chrono::steady_clock::now() < end) {
      std::this_thread::yield();
      reply = client_.read(0, 1);
    }
    return reply;
  }

  TwoPlaces places_;
  std::optional<FakeDaemon> daemon_{std::in_place, places_.here};
  Client client_{Client::connect(options_for(places_.there))};
};

TEST_F(OneDaemon, ARestartThatTheProgramDidNotNoticeIsToldBeforeAnythingIsAsked) {
  daemon_.reset();
  daemon_.emplace(places_.here);
  wait_until_known(*daemon_);
  const ParameterReply first = client_.write(0, 1, 42);
  EXPECT_EQ(first.code, ReplyCode::refused);
  EXPECT_EQ(first.cause, RefusalCause::other_daemon);
  EXPECT_EQ(first.speaker, Speaker::client);
  EXPECT_NE(first.reason.find("the daemon was started anew"), std::string::npos) << first.reason;
  EXPECT_NE(first.reason.find("nothing was sent"), std::string::npos) << first.reason;
  const ParameterReply second = read_until([](const Reply& reply) { return reply.ok(); });
  EXPECT_TRUE(second.ok()) << second.reason;
  EXPECT_EQ(second.value, 0u) << "what was written before is not served";
}

// DDS finds the endpoints of a program one by one; who records all topics reads requests, too.
TEST_F(OneDaemon, ARequestIsNotWrittenBeforeTheDaemonItselfIsKnownToReadIt) {
  const gateway::dds::Participant recorder(places_.here);
  gateway::dds::DataSignal signal;
  gateway::dds::Reader<cansync_ParameterRequest> requests(recorder, &signal);
  std::size_t recorded = 0;
  const auto record = [&] { (void)requests.take([&](const cansync_ParameterRequest&) { ++recorded; }); };
  (void)read_until([&](const Reply&) {
    record();
    return recorded != 0;
  });
  ASSERT_NE(recorded, 0u);

  daemon_.reset();
  daemon_.emplace(places_.here, FakeDaemon::ReadsParameters::later);
  wait_until_known(*daemon_);
  EXPECT_EQ(client_.read(0, 1).cause, RefusalCause::other_daemon);
  record();
  recorded = 0;
  for (int i = 0; i < 10; ++i) {
    wait_until_known(*daemon_);
    const ParameterReply reply = client_.read(0, 1, 50);
    EXPECT_EQ(reply.code, ReplyCode::no_daemon) << reply.reason;
    EXPECT_NE(reply.reason.find("nothing was sent"), std::string::npos) << reply.reason;
  }
  daemon_->read_parameters();
  EXPECT_TRUE(read_until([](const Reply& reply) { return reply.ok(); }).ok());
  EXPECT_TRUE(eventually(signal, [&] {
    record();
    return recorded >= daemon_->requests();
  }));
  EXPECT_EQ(recorded, daemon_->requests());
}

TEST_F(OneDaemon, AProgramThatHearsOfRestartsIsNotHeldUp) {
  std::atomic<int> restarts = 0;
  const Subscription told = client_.on_restart([&](const GatewayStatus&) { ++restarts; });
  wait_until_known(*daemon_);
  daemon_.reset();
  daemon_.emplace(places_.here);
  wait_until_known(*daemon_);
  const ParameterReply reply =
      read_until([](const Reply& each) { return each.ok() || each.code == ReplyCode::refused; });
  EXPECT_TRUE(reply.ok()) << reply.reason;
  EXPECT_EQ(restarts, 1);
}

TEST_F(OneDaemon, WhoAsksForRestartsWhileNoneIsThereIsToldOfTheNextOne) {
  wait_until_known(*daemon_);
  daemon_.reset();
  ASSERT_TRUE(read_until([](const Reply& reply) { return reply.code == ReplyCode::no_daemon; }).code ==
              ReplyCode::no_daemon);
  std::atomic<int> restarts = 0;
  const Subscription told = client_.on_restart([&](const GatewayStatus&) { ++restarts; });
  daemon_.emplace(places_.here);
  wait_until_known(*daemon_);
  EXPECT_EQ(restarts, 1);
  const ParameterReply reply =
      read_until([](const Reply& each) { return each.ok() || each.code == ReplyCode::refused; });
  EXPECT_TRUE(reply.ok()) << reply.reason;
}

TEST_F(OneDaemon, WhileTwoServeTheBusNothingIsAskedOfEither) {
  const ParameterJob open = client_.submit(ParameterRequest{.slave = 0, .number = FakeDaemon::kSilentNumber});
  while (daemon_->requests() < 1) std::this_thread::yield();
  std::optional<FakeDaemon> second(std::in_place, places_.here);
  wait_until_known(*second);
  ParameterReply reply = client_.read(0, 1);
  EXPECT_EQ(reply.code, ReplyCode::refused);
  EXPECT_NE(reply.reason.find("a second one serves bus testbus: "), std::string::npos) << reply.reason;
  wait_until_known(*daemon_);  // it lives
  reply = client_.read(0, 1);
  EXPECT_EQ(reply.code, ReplyCode::refused);
  EXPECT_NE(reply.reason.find("several daemons serve bus testbus"), std::string::npos) << reply.reason;
  const std::size_t named = reply.reason.find("process ");
  ASSERT_NE(named, std::string::npos) << reply.reason;
  EXPECT_NE(reply.reason.find("process ", named + 1), std::string::npos) << reply.reason;
  EXPECT_NE(reply.reason.find(" on host "), std::string::npos) << reply.reason;
  ReferenceWriter writer(client_);
  EXPECT_NE(writer.write(1, {1, 0, 0, 0}, 1).find("several daemons"), std::string::npos);

  // What was asked before is for the one that has it.
  EXPECT_TRUE(open.cancel());
  EXPECT_EQ(open.wait().code, ReplyCode::cancelled);
  EXPECT_EQ(daemon_->requests(), 1u);
  EXPECT_EQ(second->requests(), 0u);
  while (second->elsewhere() < 1) std::this_thread::yield();  // the cancel
  second.reset();
  reply = read_until([](const Reply& each) { return each.ok(); });
  EXPECT_TRUE(reply.ok()) << reply.reason;
}

/// Options of a program that means the bus of this computer alone.
Options options_on(const std::string& host, const gateway::dds::ParticipantOptions& place) {
  Options options = options_for(place, seconds(1));
  options.bus = host + "/" + options.bus;
  return options;
}

TEST(OneComputer, OfAnotherOneNothingIsAsked) {
  const TwoPlaces places;
  FakeDaemon daemon(places.here, FakeDaemon::ReadsParameters::at_once, "plc1");
  {
    // Known before: whoever waits too short for it finds no daemon at all.
    const Client any = Client::connect(options_for(places.there));
    try {
      const Client client = Client::connect(options_on("plc2", places.there));
      ADD_FAILURE() << "connected to another computer";
    } catch (const NoDaemon& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find("bus testbus of computer plc2 is not served"), std::string::npos) << text;
      EXPECT_NE(text.find("another computer serves this name"), std::string::npos) << text;
      EXPECT_NE(text.find(" on host "), std::string::npos) << text;
    }
  }
  EXPECT_EQ(daemon.requests(), 0u);
}

TEST(OneComputer, IsNamedWhenThereIsNoDaemonAtAll) {
  const TwoPlaces places;
  Options options = options_on("plc2", places.there);
  options.wait = std::chrono::milliseconds(50);
  try {
    const Client client = Client::connect(options);
    ADD_FAILURE() << "connected to nothing";
  } catch (const NoDaemon& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("is cansyncd running for bus testbus of computer plc2"), std::string::npos) << text;
  }
}

// The machine restarts after a power cut; on the network another one has its name meanwhile.
TEST(OneComputer, WhoKnowsItsDaemonAsksNoneOfAnotherComputerInItsPlace) {
  const TwoPlaces places;
  std::optional<FakeDaemon> daemon(std::in_place, places.here, FakeDaemon::ReadsParameters::at_once, "plc2");
  Options options = options_on("plc2", places.there);
  options.wait = gateway::kLongWait;
  Client client = Client::connect(options);
  EXPECT_TRUE(client.read(0, 1).ok());
  ReferenceWriter writer(client);
  daemon.reset();
  daemon.emplace(places.here, FakeDaemon::ReadsParameters::at_once, "plc1");
  const auto refused = [](const std::string& reason) {
    return reason.find("bus testbus of computer plc2 is not served") != std::string::npos;
  };
  const auto end = std::chrono::steady_clock::now() + gateway::kLongWait;
  ParameterReply reply = client.read(0, 1);
  while (!refused(reply.reason) && std::chrono::steady_clock::now() < end) reply = client.read(0, 1, 50);
  for (int i = 0; i < 3; ++i) {
    reply = client.read(0, 1);
    EXPECT_EQ(reply.code, ReplyCode::refused);
    EXPECT_EQ(reply.cause, RefusalCause::other_daemon);
    EXPECT_TRUE(refused(reply.reason)) << reply.reason;
  }
  writer.take_up();
  EXPECT_TRUE(refused(writer.write(1, {1, 0, 0, 0}, 1)));
  EXPECT_EQ(daemon->requests(), 0u);
}

TEST(OlderDaemon, IsNamedWithBothDataModels) {
  const TwoPlaces places;
  const gateway::dds::Participant older(places.here);
  gateway::dds::Writer<cansync_MasterStatus> writer(older);
  cansync_MasterStatus status = {};
  ASSERT_EQ(writer.write(status), DDS_RETCODE_OK);
  // Its status is known before: whoever waits too short for it finds no daemon at all.
  const gateway::dds::Participant before(places.there);
  gateway::dds::DataSignal signal;
  const gateway::dds::Reader<cansync_MasterStatus> statuses(before, &signal);
  ASSERT_TRUE(eventually(signal, [&] { return statuses.matched() == 1; }));
  try {
    const Client client = Client::connect(options_for(places.there, seconds(2)));
    ADD_FAILURE() << "connected to a daemon that does not understand it";
  } catch (const NoDaemon& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the daemon of bus testbus has data model 6 or older, this program 8"),
              std::string::npos)
        << text;
    EXPECT_NE(text.find("update cansyncd"), std::string::npos) << text;
  }
}

TEST(TwoDaemons, NobodyConnectsToTwo) {
  const TwoPlaces places;
  FakeDaemon one(places.here);
  FakeDaemon two(places.here);
  // Who finds one of them earlier than the other connects to it: here both are known before.
  const gateway::dds::Participant before(places.there);
  gateway::dds::DataSignal signal;
  const gateway::dds::Reader<cansync_ParameterReply> replies(before, replies_to_all(places.there), &signal);
  const gateway::dds::Reader<cansync_MasterStatus> statuses(before, &signal);
  const gateway::dds::Reader<gateway_GatewayStatus> gateways(before, &signal);
  ASSERT_TRUE(eventually(
      signal, [&] { return replies.matched() == 2 && statuses.matched() == 2 && gateways.matched() == 2; }));
  std::atomic<bool> stop = false;
  std::thread telling([&] {
    while (!stop) {
      one.tell();
      two.tell();
      std::this_thread::yield();
    }
  });
  try {
    const Client client = Client::connect(options_for(places.there));
    ADD_FAILURE() << "connected to one of two";
  } catch (const SeveralDaemons& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("several daemons serve bus testbus"), std::string::npos) << text;
    EXPECT_NE(text.find("; nothing was sent: stop all but one"), std::string::npos) << text;
  }
  stop = true;
  telling.join();
}

}  // namespace
}  // namespace cansync::client
