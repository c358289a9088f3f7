#include "rt/flight_recorder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <vector>

namespace {

using rt::FlightEntry;
using rt::FlightRecorder;
using rt::FlightTrigger;
using std::chrono::milliseconds;

FlightEntry numbered(std::uint32_t value) {
  FlightEntry entry;
  entry.value = value;
  return entry;
}

FlightTrigger because(std::uint32_t reason) {
  FlightTrigger trigger;
  trigger.reason = reason;
  return trigger;
}

std::vector<std::uint32_t> values(const FlightRecorder& recorder) {
  std::vector<std::uint32_t> out;
  for (const FlightEntry& entry : recorder.entries()) out.push_back(entry.value);
  return out;
}

TEST(FlightRecorder, KeepsTheNewestOldestFirst) {
  FlightRecorder recorder(4, 0);
  for (std::uint32_t i = 0; i < 10; ++i) recorder.record(numbered(i));
  recorder.fault(because(7));
  recorder.begin_interval(because(0));
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(values(recorder), (std::vector<std::uint32_t>{6, 7, 8, 9}));
  EXPECT_EQ(recorder.trigger().reason, 7U);
}

TEST(FlightRecorder, GoesOnForTheIntervalsAfterAFault) {
  FlightRecorder recorder(100, 2);
  recorder.record(numbered(1));
  recorder.fault(because(7));
  for (std::uint32_t interval = 2; interval < 10; ++interval) {
    recorder.begin_interval(because(0));
    EXPECT_EQ(recorder.wait_frozen(milliseconds(0)), interval >= 4) << interval;
    recorder.record(numbered(interval));
  }
  EXPECT_EQ(values(recorder), (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST(FlightRecorder, CountsFurtherFaultsUntilItIsArmedAgain) {
  FlightRecorder recorder(10, 1);
  recorder.record(numbered(1));
  EXPECT_EQ(recorder.fault(because(1)), FlightRecorder::Shown::own);
  EXPECT_EQ(recorder.fault(because(2)), FlightRecorder::Shown::another)
      << "while it goes on it is shown, too";
  recorder.begin_interval(because(0));
  recorder.begin_interval(because(0));
  EXPECT_EQ(recorder.fault(because(3)), FlightRecorder::Shown::none) << "while it is frozen";
  recorder.request();
  recorder.begin_interval(because(0));
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(recorder.trigger().reason, 1U);
  EXPECT_EQ(recorder.take_further(), 3U);
  EXPECT_EQ(recorder.take_further(), 0U);

  recorder.rearm();
  EXPECT_FALSE(recorder.wait_frozen(milliseconds(0)));
  recorder.record(numbered(5));
  recorder.fault(because(4));
  recorder.begin_interval(because(0));
  recorder.begin_interval(because(0));
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(values(recorder), std::vector<std::uint32_t>{5}) << "the recording before is not told again";
  EXPECT_EQ(recorder.trigger().reason, 4U);
}

TEST(FlightRecorder, ARequestFreezesAtTheNextInterval) {
  FlightRecorder recorder(10, 5);
  recorder.record(numbered(1));
  recorder.request();
  EXPECT_FALSE(recorder.wait_frozen(milliseconds(0)));
  recorder.begin_interval(because(9));
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(recorder.trigger().reason, 9U);
  EXPECT_EQ(values(recorder), std::vector<std::uint32_t>{1});
}

TEST(FlightRecorder, TheEndOfTheThreadFreezesWhatStillWaits) {
  FlightRecorder recorder(10, 50);
  recorder.record(numbered(1));
  recorder.finish();
  EXPECT_FALSE(recorder.wait_frozen(milliseconds(0))) << "nothing has happened";
  recorder.fault(because(7));
  recorder.begin_interval(because(0));
  recorder.record(numbered(2));
  recorder.finish();
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(recorder.trigger().reason, 7U);
  EXPECT_EQ(values(recorder), (std::vector<std::uint32_t>{1, 2}));
}

TEST(FlightRecorder, AnEmptyRingIsARecordingToo) {
  FlightRecorder recorder(0, 0);
  recorder.request();
  recorder.begin_interval(because(0));
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_TRUE(recorder.entries().empty());
}

}  // namespace
