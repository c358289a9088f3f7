#include "daemon/desk/request_series.h"

#include <gtest/gtest.h>

#include <string>

#include "daemon/desk/audit.h"
#include "support/kept_journal.h"

namespace cansyncd {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

struct NoEvents final : EventSink {
  bool publish(const EventText& /*event*/, SteadyTime /*now*/) override { return true; }
};

struct Trail {
  /// A client sends `data` on an identifier.
  void send(const std::string& client, const std::string& identifier, const std::string& data,
            bool done = true) {
    trail.ended({client, client, "", ++number}, change(identifier, data), AuditTrail::kNotKnown,
                {done ? "done" : "timeout", done}, now);
  }
  static Change change(const std::string& identifier, const std::string& data) {
    Change change{"send_frame", -1, "", identifier + "#" + data};
    change.series = identifier;
    return change;
  }
  void pass(SteadyTime::duration time) {
    now += time;
    (void)trail.tick(now);
  }
  std::string newest() const { return journal.all().back().message; }

  KeptJournal journal;
  NoEvents events;
  AuditTrail trail{journal, events, "bus", 0};
  SteadyTime now{seconds(1000)};
  std::uint64_t number = 0;
};

TEST(RequestSeries, WhatIsSentAgainAndAgainHasAnEntryAMinute) {
  Trail trail;
  for (int i = 0; i < 12'001; ++i) {  // two minutes, every 10 ms
    trail.send("plc", "123", std::to_string(i));
    trail.pass(milliseconds(10));
  }
  ASSERT_EQ(trail.journal.all().size(), 3u);
  EXPECT_EQ(trail.journal.all()[0].message, "send_frame = 123#0 (before: not known) by plc: done");
  EXPECT_EQ(trail.journal.all()[1].message,
            "send_frame = 123#5999 (before: not known) by plc: done (the last of 5999 more within 60 s)");
  EXPECT_EQ(trail.journal.all()[1].field("CANSYNC_COUNT"), "5999");
  EXPECT_EQ(trail.journal.all()[0].field("CANSYNC_COUNT"), "1");
  trail.pass(seconds(9));
  EXPECT_EQ(trail.journal.all().size(), 3u);
  trail.pass(seconds(1));
  ASSERT_EQ(trail.journal.all().size(), 4u) << "it has ended";
  EXPECT_NE(trail.newest().find("123#12000 "), std::string::npos) << trail.newest();
  trail.pass(minutes(5));
  EXPECT_EQ(trail.journal.all().size(), 4u);
  trail.send("plc", "123", "AA");
  EXPECT_EQ(trail.journal.all().size(), 5u) << "it begins again";
}

TEST(RequestSeries, OneThatIsSentOnceHasOneEntry) {
  Trail trail;
  trail.send("plc", "123", "01");
  trail.pass(minutes(3));
  EXPECT_EQ(trail.journal.all().size(), 1u);
}

TEST(RequestSeries, ClientsIdentifiersAndEndsAreApart) {
  Trail trail;
  for (int i = 0; i < 3; ++i) {
    trail.send("plc", "123", "01");
    trail.send("plc", "124", "01");
    trail.send("hmi", "123", "01");
    trail.send("plc", "123", "01", false);
  }
  EXPECT_EQ(trail.journal.all().size(), 4u);
  trail.trail.finish(trail.now);
  EXPECT_EQ(trail.journal.all().size(), 8u) << "at the end of the daemon nothing is left";
}

TEST(RequestSeries, RefusalsAreASeriesByTheirCause) {
  Trail trail;
  for (int i = 0; i < 500; ++i) {
    trail.trail.refused({"plc", "plc", "", 1}, Trail::change("123", "01"), AuditTrail::kNotKnown,
                        {gateway_CAUSE_READ_ONLY, "set access.read_only to false"}, trail.now);
    trail.trail.refused({"plc", "plc", "", 1}, Trail::change("123", "01"), AuditTrail::kNotKnown,
                        {gateway_CAUSE_STALE, std::to_string(i) + " ms ago"}, trail.now);
  }
  EXPECT_EQ(trail.journal.all().size(), 2u);
}

TEST(RequestSeries, WhoSendsOnEveryIdentifierFillsNothing) {
  Trail trail;
  for (int i = 0; i < 5000; ++i) trail.send("plc", std::to_string(i), "01");
  EXPECT_EQ(trail.journal.all().size(), RequestSeries::kMost + 1);
  trail.pass(minutes(1));
  ASSERT_EQ(trail.journal.all().size(), RequestSeries::kMost + 2) << "those beyond are one";
  EXPECT_NE(trail.newest().find("more within 60 s, of several)"), std::string::npos) << trail.newest();
}

TEST(RequestSeries, WhoIsAnotherClientEachTimeFillsNothing) {
  Trail trail;
  for (int i = 0; i < 5000; ++i) trail.send("plc " + std::to_string(i), "123", "01");
  EXPECT_EQ(trail.journal.all().size(), 2 * RequestSeries::kMost + 1);
  trail.send("plc 1", "123", "01", false);
  EXPECT_EQ(trail.journal.all().size(), 2 * RequestSeries::kMost + 2) << "another end is another series";
  trail.pass(minutes(1));
  EXPECT_NE(trail.newest().find(", of several clients)"), std::string::npos) << trail.newest();
}

TEST(RequestSeries, AtTheEndOfTheDaemonWhatWasNotRecordedIsTold) {
  Trail trail;
  for (unsigned i = 0; i < 2 * AuditTrail::kRefused; ++i)
    trail.trail.refused({"hmi", "hmi", "", i}, {"mode", -1, "", "run"}, AuditTrail::kNotKnown,
                        {gateway_CAUSE_READ_ONLY, "set access.read_only to false"}, trail.now);
  EXPECT_EQ(trail.journal.all().size(), AuditTrail::kRefused);
  trail.trail.finish(trail.now);
  EXPECT_EQ(trail.journal.all().back().field("EVENT"), "requests_not_recorded");
}

TEST(RequestSeries, EachIsRecordedOnDemandAndWhatIsNoSeriesAlways) {
  Trail trail;
  for (int i = 0; i < 3; ++i)
    trail.trail.ended({"hmi", "hmi", "", 1}, {"mode", -1, "", "run"}, AuditTrail::kNotKnown, {"done", true},
                      trail.now);
  EXPECT_EQ(trail.journal.all().size(), 3u);
  trail.trail.set_record_each(true);
  for (int i = 0; i < 3; ++i) trail.send("plc", "123", "01");
  EXPECT_EQ(trail.journal.all().size(), 6u);
}

}  // namespace
}  // namespace cansyncd
