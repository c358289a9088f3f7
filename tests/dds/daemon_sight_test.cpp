#include "dds/ask/daemon_sight.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <thread>

#include "dds/bounded_text.h"
#include "dds/overview/overview_topics.h"
#include "support/dds_places.h"

namespace gateway::dds {
namespace {

constexpr DaemonIdentity kFirst = {1};
constexpr DaemonIdentity kSecond = {2};

/// A program's endpoints, which come one after the other.
class Program {
 public:
  explicit Program(const ParticipantOptions& place) : participant_(place) {}
  void tell(const DaemonIdentity& identity, const char* host = "plc1") {
    gateway_GatewayStatus status = {};
    set_daemon(identity, status);
    copy_text(host, status.host);
    EXPECT_EQ(status_.emplace(participant_).write(status), DDS_RETCODE_OK);
  }
  void read_requests() { requests_.emplace(participant_); }
  void write_replies() { replies_.emplace(participant_); }

 private:
  Participant participant_;
  std::optional<Writer<gateway_GatewayStatus>> status_;
  std::optional<Reader<gateway_JobEnd>> requests_;
  std::optional<Writer<gateway_JobEndReply>> replies_;
};

class DaemonSightTest : public testing::Test {
 protected:
  DaemonSightTest() {
    daemon.emplace(places.here);
    daemon->read_requests();
    daemon->write_replies();
    daemon->tell(kFirst);
    options.wait = gateway::kLongWait;
    sight.find(
        options, signal, "", {.requests = {&requests}, .replies = {&replies}}, [] { return true; },
        [] { return false; });
  }
  template <class Condition>
  bool look_until(Condition&& condition) {
    return eventually(signal, [&] {
      sight.look();
      return condition();
    });
  }
  /// Why nothing may be asked; empty: it may.
  std::string reason() {
    sight.look();
    const auto obstacle = sight.obstacle();
    return obstacle ? obstacle->reason : "";
  }
  /// Another start of the daemon, which tells its status alone, in the place of the first.
  void start_anew() {
    daemon.reset();
    daemon.emplace(places.here);
    daemon->tell(kSecond);
    ASSERT_TRUE(look_until([&] {
      return sight.choice().view() == DaemonChoice::View::one && sight.choice().daemon() == kSecond;
    }));
  }

  const TwoPlaces places;
  std::optional<Program> daemon;
  const Participant there{places.there};
  DataSignal signal;
  ClientOptions options;
  DaemonSight sight{there, signal, "plc1/testbus"};
  Writer<gateway_JobEnd> requests{there, 0, &signal};
  Reader<gateway_JobEndReply> replies{there, &signal};
};

// DDS finds the endpoints of a program one by one; a request to a reader that is not known yet is lost.
TEST_F(DaemonSightTest, ADaemonThatHasJustComeIsAskedOnceEachOfItsTopicsIsKnown) {
  EXPECT_EQ(reason(), "");
  start_anew();
  EXPECT_NE(reason().find("not all of its topics are known"), std::string::npos) << reason();
  daemon->read_requests();
  ASSERT_TRUE(look_until([&] { return sight.is_read(requests); }));
  EXPECT_NE(reason().find("not all of its topics are known"), std::string::npos) << reason();
  daemon->write_replies();
  ASSERT_TRUE(look_until([&] { return sight.is_written(replies); }));
  EXPECT_NE(reason().find("started anew"), std::string::npos) << "not told before: " << reason();
  EXPECT_EQ(reason(), "");
}

TEST_F(DaemonSightTest, OfAnotherComputerNothingIsAsked) {
  daemon.reset();
  daemon.emplace(places.here);
  daemon->read_requests();
  daemon->write_replies();
  daemon->tell(kSecond, "plc2");
  ASSERT_TRUE(look_until([&] {
    return sight.choice().view() == DaemonChoice::View::one && sight.choice().daemon() == kSecond &&
           requests.matched() == 1 && replies.matched() == 1;
  }));
  for (int i = 0; i < 3; ++i)
    EXPECT_NE(reason().find("bus testbus of computer plc1 is not served"), std::string::npos) << reason();
  EXPECT_FALSE(sight.is_read(requests));
  EXPECT_FALSE(sight.is_written(replies));
}

TEST_F(DaemonSightTest, TopicsOfAnotherProgramAreNotThoseOfTheDaemon) {
  Program other(places.here);
  other.read_requests();
  other.write_replies();
  ASSERT_TRUE(look_until([&] { return requests.matched() == 2 && replies.matched() == 2; }));
  start_anew();
  ASSERT_TRUE(look_until([&] { return requests.matched() == 1 && replies.matched() == 1; }));
  EXPECT_FALSE(sight.is_read(requests));
  EXPECT_FALSE(sight.is_written(replies));
  EXPECT_NE(reason().find("not all of its topics are known"), std::string::npos) << reason();
}

TEST_F(DaemonSightTest, WhoWaitsForTheWaysMayAskWhenTheyCome) {
  start_anew();
  const std::jthread soon([this] {
    daemon->read_requests();
    daemon->write_replies();
  });
  // A computer that stands still may have it end after its second.
  while (!sight.is_read(requests) || !sight.is_written(replies)) sight.look_until_reached(options, signal);
  EXPECT_NE(reason().find("started anew"), std::string::npos) << reason();
}

}  // namespace
}  // namespace gateway::dds
