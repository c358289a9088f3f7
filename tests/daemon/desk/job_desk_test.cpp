#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dds/overview/open_requests.h"
#include "dds/overview/overview_topics.h"
#include "made_up_protocol.h"
#include "support/dds_places.h"
#include "support/kept_journal.h"

/// A desk for a protocol of the test's own: one topic of requests, and nothing that a protocol may leave out.
namespace cansyncd {
namespace {

using made_up::Executor;
using made_up::Granted;
using made_up::Wish;

static_assert(RequestProtocol<made_up::Protocol>);
static_assert(!Replaces<made_up::Protocol> && !GivesOwn<made_up::Protocol>);
static_assert(!KeepsState<made_up::Protocol> && !ShowsProgress<made_up::WishTopic>);

constexpr gateway::dds::DaemonIdentity kThis = {0xDA, 1};
constexpr gateway::dds::DaemonIdentity kOther = {0xDA, 2};
constexpr gateway::dds::DaemonIdentity kNobody = {};

/// A client of the made-up topics in another place.
class Client {
 public:
  explicit Client(const gateway::dds::ParticipantOptions& options)
      : participant_(options),
        answers_(participant_, replies_to_all(options), &signal_),
        wishes_(participant_, 0, &signal_),
        cancels_(participant_, 0, &signal_) {}

  bool wait_for_desks(unsigned desks) {
    return eventually(signal_, [&] {
      return answers_.matched() >= desks && wishes_.matched() >= desks && cancels_.matched() >= desks;
    });
  }
  void wish(std::uint64_t request, std::uint32_t number, const gateway::dds::DaemonIdentity& daemon = kThis) {
    made_up_Wish sample = {};
    sample.client[0] = 1;
    sample.request = request;
    sample.number = number;
    gateway::dds::set_daemon(daemon, sample);
    gateway::dds::copy_text("tester", sample.client_name);
    deliver(wishes_, sample);
  }
  /// Writes many of them, and comes back when the desk's reader has them.
  void wish_many(std::uint64_t last, const gateway::dds::DaemonIdentity& daemon) {
    made_up_Wish sample = {};
    sample.client[0] = 1;
    gateway::dds::set_daemon(daemon, sample);
    for (sample.request = 1; sample.request < last; ++sample.request)
      ASSERT_EQ(wishes_.write(sample), DDS_RETCODE_OK);
    deliver(wishes_, sample);
  }
  void cancel(std::uint64_t request, const gateway::dds::DaemonIdentity& daemon = kThis) {
    gateway_JobCancel sample = {};
    sample.client[0] = 1;
    sample.request = request;
    gateway::dds::set_daemon(daemon, sample);
    deliver(cancels_, sample);
  }
  /// Everything that has come to this request, until `last` is answered.
  std::vector<made_up_Answer> answers_until(std::uint64_t last) {
    EXPECT_TRUE(eventually(signal_, [&] {
      answers_.take([&](const made_up_Answer& answer) { came_.push_back(answer); });
      return std::any_of(came_.begin(), came_.end(), [&](const auto& a) { return a.request == last; });
    }));
    return came_;
  }
  std::size_t count(std::uint64_t request) const {
    return static_cast<std::size_t>(
        std::count_if(came_.begin(), came_.end(), [&](const auto& a) { return a.request == request; }));
  }
  made_up_Answer answer(std::uint64_t request) {
    for (const made_up_Answer& came : answers_until(request)) {
      if (came.request == request) return came;
    }
    return {};
  }

 private:
  template <class T>
  static void deliver(gateway::dds::Writer<T>& writer, const T& sample) {
    ASSERT_EQ(writer.write(sample), DDS_RETCODE_OK);
    ASSERT_EQ(dds_wait_for_acks(writer.handle(), DDS_SECS(20)), DDS_RETCODE_OK);
  }

  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  gateway::dds::Reader<made_up_Answer> answers_;
  gateway::dds::Writer<made_up_Wish> wishes_;
  gateway::dds::Writer<gateway_JobCancel> cancels_;
  std::vector<made_up_Answer> came_;
};

/// A desk whose passes the test makes itself.
class MadeUpDesk : public ::testing::Test {
 protected:
  MadeUpDesk()
      : participant_(places_.here),
        events_(participant_, journal, "madeup0"),
        trail_(journal, events_, "madeup0", 1),
        desk(participant_, signal_, events_, trail_, made_up::Protocol{}, kThis, false),
        client(places_.there) {
    EXPECT_TRUE(client.wait_for_desks(1));
  }

  made_up::Context context() { return {executor, std::chrono::steady_clock::now(), rules}; }

  /// Passes of the gateway thread until `condition` holds.
  template <class Condition>
  void pass_until(Condition&& condition) {
    EXPECT_TRUE(eventually(signal_, [&] {
      if (desk.take_requests(context())) signal_.raise();
      if (desk.retry(context())) signal_.raise();
      return condition();
    }));
  }
  Wish next_wish() {
    pass_until([&] { return !executor.wishes.empty(); });
    if (executor.wishes.empty()) return {};
    const Wish wish = executor.wishes.front();
    executor.wishes.pop_front();
    return wish;
  }
  std::uint64_t rejected(Rejection kind) const { return desk.rejections()[static_cast<unsigned>(kind)]; }
  void grant(const Wish& wish) { desk.finish(Granted{wish.id, std::nullopt}, context()); }
  void write_replies() {
    pass_until([&] { return !desk.replies_waiting(); });
  }

  TwoPlaces places_{"madeup0"};
  gateway::dds::Participant participant_;
  gateway::dds::DataSignal signal_;
  KeptJournal journal;
  EventPublisher events_;
  AuditTrail trail_;
  Executor executor;
  RequestRules rules;
  JobDesk<made_up::Protocol> desk;
  Client client;
};

TEST(WhoOf, ANameIsTextAndNothingElse) {
  const Requester who = who_of(
      "hmi\n12:00 info request_done \x1b[2J S\xc3\xbc"
      "d",
      {}, {});
  EXPECT_EQ(who.name,
            "hmi\\x0a12:00 info request_done \\x1b[2J S\xc3\xbc"
            "d");
  EXPECT_EQ(who.label, "'" + who.name + "' (00000000)");
}

TEST_F(MadeUpDesk, ARequestIsHandedOnAndAnsweredOnce) {
  client.wish(1, 42);
  const Wish wish = next_wish();
  EXPECT_EQ(wish.number, 42u);
  EXPECT_EQ(desk.clients(), 1u);
  grant(wish);
  grant(wish);  // nobody's any more
  client.wish(2, 43);
  grant(next_wish());
  write_replies();
  EXPECT_EQ(client.answer(1).code, gateway_REPLY_DONE);
  EXPECT_EQ(client.answer(2).code, gateway_REPLY_DONE);
  EXPECT_EQ(client.count(1), 1u);
}

// Answered by this one, its client would ask again for what the other carries out.
TEST_F(MadeUpDesk, WhatIsMeantForAnotherDaemonIsNeitherTakenNorAnswered) {
  client.wish(1, 42, kOther);
  client.wish(2, 43);
  const Wish wish = next_wish();
  EXPECT_EQ(wish.number, 43u);
  grant(wish);
  write_replies();
  EXPECT_EQ(client.answer(2).code, gateway_REPLY_DONE);
  EXPECT_EQ(client.count(1), 0u);
  EXPECT_TRUE(executor.wishes.empty());
  EXPECT_EQ(rejected(Rejection::other_daemon), 1u);
  EXPECT_EQ(journal.wait_for("EVENT", "requests_rejected").size(), 1u);
}

TEST_F(MadeUpDesk, AlsoWhenItsClientAsksForMoreThanMayWait) {
  constexpr std::uint64_t kMany = 3 * JobBook::kPerClient;
  client.wish_many(kMany, kOther);
  client.wish(kMany + 1, 43);
  grant(next_wish());
  pass_until([&] { return rejected(Rejection::other_daemon) == kMany; });
  write_replies();
  EXPECT_EQ(client.answer(kMany + 1).code, gateway_REPLY_DONE)
      << "what is meant for others leaves room for it";
  for (std::uint64_t request = 1; request <= kMany; ++request) EXPECT_EQ(client.count(request), 0u);
}

TEST_F(MadeUpDesk, WhatNamesNoDaemonIsRefusedInWords) {
  client.wish(1, 42, kNobody);
  pass_until([&] { return rejected(Rejection::other_daemon) == 1; });
  write_replies();
  EXPECT_EQ(client.answer(1).cause, gateway_CAUSE_OTHER_DAEMON);
  EXPECT_EQ(client.answer(1).reason, kNamesNoDaemon);
  EXPECT_TRUE(executor.wishes.empty());
}

TEST_F(MadeUpDesk, ACancelForAnotherDaemonOrNoneCancelsNothing) {
  client.wish(1, 1);
  const Wish first = next_wish();
  client.cancel(1, kOther);
  client.cancel(1, kNobody);
  pass_until([&] { return rejected(Rejection::other_daemon) == 2; });
  EXPECT_TRUE(executor.cancelled.empty());
  grant(first);
  write_replies();
  EXPECT_EQ(client.answer(1).code, gateway_REPLY_DONE);
}

TEST_F(MadeUpDesk, WhatIsOpenIsToldAndAnybodyMayEndIt) {
  const gateway::dds::Participant third(places_.there);
  gateway::dds::DataSignal signal;
  gateway::dds::OpenRequestsReader open(third, &signal);
  gateway::dds::Writer<gateway_JobEnd> ends(third, 0, &signal);
  gateway::dds::Reader<gateway_JobEndReply> replies(third, replies_to_all(places_.there), &signal);
  client.wish(1, 42);
  const Wish wish = next_wish();
  const auto told = [&](std::size_t requests) {
    const auto& now = open.look();
    return now && now->requests.size() == requests;
  };
  pass_until([&] { return told(1) && ends.matched() != 0 && replies.matched() != 0; });
  const gateway_OpenRequest row = open.look()->requests.front();
  EXPECT_EQ(row.job, wish.id);
  EXPECT_STREQ(row.name, "tester");
  EXPECT_STREQ(row.text, "wish 42");
  EXPECT_FALSE(row.waits);
  EXPECT_EQ(open.look()->open, 1u);

  std::vector<gateway_JobEndReply> came;
  const auto end_job = [&](std::uint64_t request, std::uint64_t job) {
    gateway_JobEnd sample = {};
    sample.client[0] = 7;
    sample.request = request;
    sample.job = job;
    gateway::dds::set_daemon(kThis, sample);
    ASSERT_EQ(ends.write(sample), DDS_RETCODE_OK);
    pass_until([&] {
      replies.take([&](const gateway_JobEndReply& reply) { came.push_back(reply); });
      return came.size() == request;
    });
  };
  end_job(1, 999);
  end_job(2, wish.id);
  ASSERT_EQ(came.size(), 2u);
  EXPECT_EQ(came[0].cause, gateway_CAUSE_UNKNOWN_JOB);
  EXPECT_EQ(came[1].code, gateway_REPLY_DONE);
  EXPECT_STREQ(came[1].ended, "wish 42 of 'tester' (01000000)");
  pass_until([&] { return !executor.cancelled.empty(); });
  EXPECT_EQ(executor.cancelled.front(), wish.id) << "what executes it ends it";
  grant(wish);
  pass_until([&] { return told(0); });
}

TEST_F(MadeUpDesk, EveryEndStandsInTheAuditTrailWithoutAnOldValue) {
  client.wish(1, 42);
  grant(next_wish());
  client.wish(2, 43);
  desk.finish(Granted{next_wish().id, gateway::dds::Denial{gateway_CAUSE_KIND, "no more of these"}},
              context());
  write_replies();
  EXPECT_EQ(client.answer(2).code, gateway_REPLY_REFUSED);
  EXPECT_EQ(client.answer(2).cause, gateway_CAUSE_KIND);
  EXPECT_STREQ(client.answer(2).reason, "no more of these");
  const auto changes = journal.changes();
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].message, "wish = 42 (before: not known) by 'tester' (01000000): granted");
  EXPECT_EQ(changes[1].message,
            "wish = 43 (before: not known) by 'tester' (01000000): refused: kind: no more of these");
}

TEST_F(MadeUpDesk, AProtocolThatForgetsTheCauseAnswersWithAnUnknownOne) {
  client.wish(1, 42);
  desk.finish(Granted{next_wish().id, gateway::dds::Denial{gateway_CAUSE_NONE, "careless"}}, context());
  write_replies();
  EXPECT_EQ(client.answer(1).code, gateway_REPLY_REFUSED);
  EXPECT_EQ(client.answer(1).cause, gateway_CAUSE_UNKNOWN);
}

TEST_F(MadeUpDesk, AKindThatIsNotKnownIsRefusedAsSuch) {
  client.wish(1, made_up::kUnknownKind);
  pass_until([&] { return desk.rejections()[static_cast<unsigned>(Rejection::value)] == 1; });
  write_replies();
  EXPECT_EQ(client.answer(1).code, gateway_REPLY_REFUSED);
  EXPECT_EQ(client.answer(1).cause, gateway_CAUSE_KIND);
}

TEST_F(MadeUpDesk, WhatComesWhileTheDaemonStopsIsRefusedAsSuch) {
  client.wish(1, 42);
  desk.stop(context());
  write_replies();
  EXPECT_EQ(client.answer(1).code, gateway_REPLY_REFUSED);
  EXPECT_EQ(client.answer(1).cause, gateway_CAUSE_STOPPING);
  EXPECT_TRUE(executor.wishes.empty());
}

TEST_F(MadeUpDesk, TheSecondUseOfANumberIsRefused) {
  client.wish(1, 42);
  const Wish first = next_wish();
  client.wish(1, 43);
  pass_until([&] { return desk.rejections()[static_cast<unsigned>(Rejection::number)] == 1; });
  write_replies();
  EXPECT_NE(std::string(client.answer(1).reason).find("this number is open already"), std::string::npos);
  EXPECT_TRUE(executor.wishes.empty());
  grant(first);
  write_replies();
  client.wish(1, 44);
  pass_until([&] { return desk.rejections()[static_cast<unsigned>(Rejection::number)] == 2; });
  EXPECT_TRUE(executor.wishes.empty());
}

TEST_F(MadeUpDesk, AFieldOutOfRangeIsRefused) {
  client.wish(1, 100);
  pass_until([&] { return desk.rejections()[static_cast<unsigned>(Rejection::value)] == 1; });
  write_replies();
  EXPECT_STREQ(client.answer(1).reason, "number: allowed 0..99");
}

TEST_F(MadeUpDesk, AReadOnlyDaemonTakesNothingThatChangesSomething) {
  rules.read_only = true;
  client.wish(1, 42);
  pass_until([&] { return desk.rejections()[static_cast<unsigned>(Rejection::state)] == 1; });
  write_replies();
  EXPECT_NE(std::string(client.answer(1).reason).find("access.read_only"), std::string::npos);
}

TEST_F(MadeUpDesk, WhatWaitsIsCancelledAtOnceAndWhatWasHandedOnByItsExecutor) {
  client.wish(1, 1);
  const Wish first = next_wish();
  client.wish(2, 2);
  const Wish second = next_wish();
  client.wish(3, 3);  // two of the lane are with the executor: it waits
  client.cancel(1);
  client.cancel(3);
  pass_until([&] { return !executor.cancelled.empty(); });
  write_replies();
  EXPECT_EQ(executor.cancelled, std::vector<JobId>{first.id});
  EXPECT_STREQ(client.answer(3).reason, "cancelled");
  EXPECT_EQ(client.count(1), 0u);
  grant(second);
  grant(first);
  write_replies();
  EXPECT_TRUE(client.answer(1).code == gateway_REPLY_DONE) << "the executor was faster than the cancel";
}

TEST_F(MadeUpDesk, ACancelThatCameBeforeItsRequestIsKept) {
  client.cancel(1);
  pass_until([&] { return desk.clients() == 1; });
  client.wish(1, 1);
  client.wish(2, 2);
  EXPECT_EQ(next_wish().number, 2u);
  write_replies();
  EXPECT_STREQ(client.answer(1).reason, "cancelled");
}

TEST_F(MadeUpDesk, WhatFindsNoRoomIsHandedOnLater) {
  executor.room = 0;
  client.wish(1, 1);
  std::optional<SteadyTime> again;
  pass_until([&] { return desk.clients() == 1; });
  again = desk.retry(context());
  EXPECT_TRUE(again) << "nobody else wakes the desk when there is room";
  executor.room = 1;
  EXPECT_EQ(next_wish().number, 1u);
}

TEST_F(MadeUpDesk, AllEndsWhenItStops) {
  client.wish(1, 1);
  const Wish first = next_wish();
  client.wish(2, 2);
  client.wish(3, 3);
  client.wish(4, 4);
  desk.stop(context());
  write_replies();
  for (std::uint64_t request = 1; request <= 4; ++request) {
    // Whether it was taken before or comes while the desk stops.
    const gateway_ReplyCode code = client.answer(request).code;
    EXPECT_TRUE(request == 1 ? code == gateway_REPLY_MASTER_STOPPED
                             : code == gateway_REPLY_MASTER_STOPPED || code == gateway_REPLY_REFUSED)
        << request;
    EXPECT_EQ(client.count(request), 1u);
  }
  grant(first);
  EXPECT_FALSE(desk.replies_waiting()) << "it was answered";
}

/// Knows what the value was before: the number of the wish.
struct Remembering : made_up::Protocol {
  static std::string before(const Wish& wish, const auto& /*state*/) { return std::to_string(wish.number); }
};

TEST_F(MadeUpDesk, NothingIsSaidOfTheValueBeforeOfWhatWasNotLookedAt) {
  JobDesk<Remembering> other(participant_, signal_, events_, trail_, Remembering{}, kThis, false);
  ASSERT_TRUE(client.wait_for_desks(2));
  client.wish(1, 7);
  other.stop(context());
  const std::vector<KeptJournal::Entry> ended = journal.all();
  ASSERT_FALSE(ended.empty());
  EXPECT_TRUE(ended.front().message.starts_with("wish = 7 (before: not known)")) << ended.front().message;
}

}  // namespace
}  // namespace cansyncd
