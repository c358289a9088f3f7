#include "cli/look/event_filter.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "cli/text/values.h"

namespace cansync::cli {
namespace {

constexpr std::int64_t kNs = 1'000'000'000;
constexpr std::int64_t kNow = 1'795'183'200 * kNs;  // 2026-11-20 14:00:00 UTC

client::Event event_of(const char* code, gateway_EventSeverity severity, int slave, std::int64_t time) {
  client::Event event = {};
  std::snprintf(event.code, sizeof event.code, "%s", code);
  event.severity = severity;
  event.slave = slave;
  event.time = time;
  return event;
}

class SinceText : public testing::Test {
 protected:
  SinceText() {
    setenv("TZ", "UTC", 1);  // NOLINT(concurrency-mt-unsafe): this test has one thread
    tzset();
  }
};

TEST_F(SinceText, LengthsGoBackFromNow) {
  EXPECT_EQ(parse_since("90s", kNow), kNow - 90 * kNs);
  EXPECT_EQ(parse_since("10m", kNow), kNow - 600 * kNs);
  EXPECT_EQ(parse_since("2h", kNow), kNow - 7200 * kNs);
  EXPECT_EQ(parse_since("1d", kNow), kNow - 86400 * kNs);
}

TEST_F(SinceText, TimesOfDayAreTheLastSuchTime) {
  EXPECT_EQ(parse_since("13:30", kNow), kNow - 1800 * kNs);
  EXPECT_EQ(parse_since("13:59:30", kNow), kNow - 30 * kNs);
  EXPECT_EQ(parse_since("14:00", kNow), kNow);
  EXPECT_EQ(parse_since("14:01", kNow), kNow + 60 * kNs - 86400 * kNs) << "yesterday's";
}

TEST_F(SinceText, DatesMayHaveATime) {
  EXPECT_EQ(parse_since("2026-11-20", kNow), kNow - 14 * 3600 * kNs);
  EXPECT_EQ(parse_since("2026-11-19 14:00", kNow), kNow - 86400 * kNs);
  EXPECT_EQ(parse_since("2026-11-20 13:59:59", kNow), kNow - kNs);
}

TEST_F(SinceText, EverythingElseIsRefused) {
  for (const char* text : {"", "10", "10x", "-5m", "1.5h", "10 m", "99999999999999999999s", "25:00", "12:60",
                           "2026-13-01", "2026-11-20 14:01", "2027-01-01", "yesterday", "13:30 ", "1000000d"})
    EXPECT_THROW(parse_since(text, kNow), UsageError) << text;
}

TEST(EventFilter, EveryConditionMustHold) {
  const auto lost = event_of("slave_lost", gateway_SEVERITY_ERROR, 3, kNow);
  EXPECT_TRUE(passes({}, lost));
  EXPECT_TRUE(passes({kNow, gateway_SEVERITY_ERROR, {"syncs_missed", "slave_lost"}, 0b1000u}, lost));
  EXPECT_FALSE(passes({kNow + 1, gateway_SEVERITY_INFO, {}, std::nullopt}, lost));
  EXPECT_FALSE(passes({0, gateway_SEVERITY_INFO, {"slave_lost_"}, std::nullopt}, lost));
  EXPECT_FALSE(passes({0, gateway_SEVERITY_INFO, {}, 0b0111u}, lost));
}

TEST(EventFilter, LevelIsAtLeast) {
  EventFilter filter;
  filter.least = gateway_SEVERITY_WARNING;
  EXPECT_FALSE(passes(filter, event_of("a", gateway_SEVERITY_INFO, -1, 0)));
  EXPECT_TRUE(passes(filter, event_of("a", gateway_SEVERITY_WARNING, -1, 0)));
  EXPECT_TRUE(passes(filter, event_of("a", gateway_SEVERITY_ERROR, -1, 0)));
}

TEST(EventFilter, WhatConcernsNoSlavePassesNoListOfSlaves) {
  EventFilter filter;
  filter.slaves = 0xFFFFFFFFu;
  EXPECT_FALSE(passes(filter, event_of("a", gateway_SEVERITY_ERROR, -1, 0)));
  EXPECT_TRUE(passes(filter, event_of("a", gateway_SEVERITY_ERROR, 31, 0)));
}

TEST(EventCodes, AreSplitAtCommas) {
  EXPECT_EQ(parse_codes("slave_lost,bus_off"), (std::vector<std::string>{"slave_lost", "bus_off"}));
  for (const char* text : {"", "a,", ",a", "a b", "Slave", "a;b"})
    EXPECT_THROW(parse_codes(text), UsageError) << text;
}

}  // namespace
}  // namespace cansync::cli
