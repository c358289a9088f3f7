// The flight recorder behind the realtime loop, in virtual time: what is kept around a fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <string>
#include <variant>
#include <vector>

#include "daemon/cansync/realtime/flight_reports.h"
#include "daemon/loop/flight_tap.h"
#include "daemon/recorder/flight_files.h"
#include "support/loop_rig.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using Kind = rt::FlightEntry::Kind;

/// The loop on its scripted bus, with a recorder between. The wall clock is one hour ahead of the bus's.
class Flight {
 public:
  explicit Flight(std::size_t entries, std::uint64_t after, const FlightTriggers& triggers = {})
      : recorder(entries, after),
        tap(recorder, triggers),
        rig(with(&tap)),
        bus(rig.bus, tap),
        loop(master_settings(3), wired(with(&tap), rig.bus), bus, rig.exchange) {}

  static LoopSettings with(FlightTap* tap) {
    LoopSettings settings = virtual_time();
    settings.epoch = std::chrono::hours(1);
    settings.tap = tap;
    return settings;
  }

  /// Runs until SYNC number `n`, with reference values from the 20th on.
  void run_until(unsigned n) {
    cansync::ReferenceUpdate update;
    update.value = {1, 2, 3, 4};
    update.valid_mask = 0x0F;
    update.release_intervals = 500;
    rig.push_at(20, update);
    rig.at(n, can::Time{0}, [this] { loop.request_stop(); });
    loop.run();
  }

  FlightRecording recording() {
    EXPECT_TRUE(recorder.wait_frozen(milliseconds(0)));
    return {recorder.trigger(), recorder.entries(), recorder.take_further()};
  }

  rt::FlightRecorder recorder;
  FlightTap tap;
  LoopRig rig;
  RecordedBus bus;
  RealtimeLoop loop;
};

std::vector<rt::FlightEntry> of_kind(const FlightRecording& recording, Kind kind) {
  std::vector<rt::FlightEntry> out;
  std::copy_if(recording.entries.begin(), recording.entries.end(), std::back_inserter(out),
               [kind](const rt::FlightEntry& entry) { return entry.kind == kind; });
  return out;
}

TEST(Flight, WhatSurroundsSkippedEdgesIsExact) {
  Flight flight(4096, 3);
  // The thread sleeps 20 intervals too long at SYNC 100.
  const can::Time late_edge = flight.rig.first_sync() + 100 * flight.rig.interval;
  flight.rig.bus.lateness = [&](can::Time deadline) {
    return deadline == late_edge ? 20 * flight.rig.interval + microseconds(7) : can::Time{0};
  };
  flight.run_until(200);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::syncs_missed));
  EXPECT_EQ(recording.trigger.detail, 20U);
  EXPECT_EQ(recording.trigger.interval, 120U);
  EXPECT_EQ(recording.trigger.wall_clock_offset, std::chrono::hours(1));

  const auto wakes = of_kind(recording, Kind::wake);
  const auto late = std::find_if(wakes.begin(), wakes.end(),
                                 [&](const rt::FlightEntry& entry) { return entry.due == late_edge; });
  ASSERT_NE(late, wakes.end());
  EXPECT_EQ(late->at - late->due, 20 * flight.rig.interval + microseconds(7));
  // Every other wake-up came when it was due: WRC1, WRC2, CC and the edge of each interval.
  EXPECT_EQ(
      std::count_if(wakes.begin(), wakes.end(), [](const auto& entry) { return entry.at != entry.due; }), 1);

  const auto edges = of_kind(recording, Kind::edge);
  ASSERT_FALSE(edges.empty());
  // Edge 99, none until 120, then the three intervals after the fault up to the edge that ends them.
  std::vector<long> numbers;
  numbers.reserve(edges.size());
  for (const auto& entry : edges)
    numbers.push_back((entry.due - flight.rig.first_sync()) / flight.rig.interval);
  const auto at_99 = std::find(numbers.begin(), numbers.end(), 99);
  ASSERT_NE(at_99, numbers.end());
  EXPECT_EQ(std::vector<long>(at_99, numbers.end()), (std::vector<long>{99, 120, 121, 122, 123, 124}));
}

TEST(Flight, EveryFrameOfTheBusIsKept) {
  Flight flight(65536, 0);
  flight.rig.at(150, can::Time{0}, [&] { flight.recorder.request(); });
  flight.run_until(160);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::requested));
  EXPECT_TRUE(flight.recorder.trigger().interval == 150 || flight.recorder.trigger().interval == 151);
  // The bus's own account of what was handed to it, up to where the recording ends.
  std::vector<can::Frame> handed;
  for (const auto& sent : flight.rig.bus.sent) {
    if (sent.at < recording.trigger.at) handed.push_back(sent.frame);
  }
  const auto sent = of_kind(recording, Kind::sent);
  ASSERT_EQ(sent.size(), handed.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(sent[i].frame, handed[i]) << i;
  EXPECT_GT(of_kind(recording, Kind::received).size(), 100U);
  const auto states = of_kind(recording, Kind::state);
  ASSERT_FALSE(states.empty());
  EXPECT_EQ(states.back().value, static_cast<std::uint32_t>(cansync::State::active_master));
}

TEST(Flight, ATelegramThatIsTooLateStandsInItAsLeftOut) {
  Flight flight(65536, 2);
  flight.rig.at(100, can::Time{0}, [&] { flight.rig.bus.send_result = can::SendResult::queue_full; });
  flight.run_until(120);
  const FlightRecording recording = flight.recording();
  EXPECT_EQ(recording.trigger.reason, static_cast<std::uint32_t>(FlightReason::sending_failed));
  const auto left_out = of_kind(recording, Kind::left_out);
  ASSERT_FALSE(left_out.empty());
  const auto sent = of_kind(recording, Kind::sent);
  ASSERT_FALSE(sent.empty());
  EXPECT_EQ(sent.back().value, static_cast<std::uint32_t>(can::SendResult::queue_full));
}

/// A tap alone, with the faults of one reason at given times. Each recording is taken at once.
class Faults {
 public:
  /// Seconds of those that were recorded.
  std::vector<int> recorded_of(const std::vector<int>& seconds, FlightReason reason) {
    std::vector<int> out;
    for (const int second : seconds) {
      Moment when{++interval_, std::chrono::seconds(second), {}};
      tap_.at(when);
      tap_.fault(reason, 1, when);
      tap_.at({++interval_, when.bus, {}});
      if (!recorder_.wait_frozen(milliseconds(0))) continue;
      out.push_back(second);
      further_ += recorder_.take_further();
      recorder_.rearm();
    }
    return out;
  }
  std::uint64_t further() { return further_ + recorder_.take_further(); }

 private:
  rt::FlightRecorder recorder_{256, 0};
  FlightTap tap_{recorder_, {}};
  IntervalNumber interval_ = 0;
  std::uint64_t further_ = 0;
};

TEST(Flight, OfAFaultThatRepeatsTheBeginningIsRecordedAndTheRestCounted) {
  Faults faults;
  std::vector<int> flapping;
  for (int second = 100; second < 4000; ++second) flapping.push_back(second);
  EXPECT_EQ(faults.recorded_of(flapping, FlightReason::bus_off), std::vector<int>{100});
  EXPECT_EQ(faults.further(), flapping.size() - 1);
  EXPECT_EQ(faults.recorded_of({4010}, FlightReason::slave_lost), std::vector<int>{4010}) << "another reason";
  EXPECT_EQ(faults.recorded_of({4058}, FlightReason::bus_off), std::vector<int>{})
      << "59 s after the last one";
  EXPECT_EQ(faults.recorded_of({4118}, FlightReason::bus_off), std::vector<int>{4118}) << "60 s of quiet";
}

TEST(Flight, ASlaveThatFlapsHidesNoOtherAndAllTogetherAreBounded) {
  rt::FlightRecorder recorder(256, 0);
  FlightTap tap(recorder, {});
  const auto recorded = [&](int second, std::uint64_t slave) {
    const Moment when{static_cast<IntervalNumber>(second), std::chrono::seconds(second), {}};
    tap.fault(FlightReason::slave_lost, slave, when);
    tap.at(when);
    const bool frozen = recorder.wait_frozen(milliseconds(0));
    if (frozen) recorder.rearm();
    return frozen;
  };
  EXPECT_TRUE(recorded(100, 3));
  for (int second = 140; second < 900; second += 40) EXPECT_FALSE(recorded(second, 3));
  EXPECT_TRUE(recorded(905, 5)) << "the first loss of another slave";
  for (std::uint64_t slave = 6; slave < 10; ++slave)
    EXPECT_TRUE(recorded(910 + static_cast<int>(slave), slave));
  EXPECT_FALSE(recorded(930, 11)) << "the seventh within an hour";
  EXPECT_TRUE(recorded(3701, 11));
}

TEST(Flight, WhatOneRecordingShowsCountsAsOne) {
  rt::FlightRecorder recorder(256, 0);
  FlightTap tap(recorder, {});
  const auto recorded_at = [&](int second) {
    tap.at({static_cast<IntervalNumber>(second), std::chrono::seconds(second), {}});
    const bool frozen = recorder.wait_frozen(milliseconds(0));
    if (frozen) recorder.rearm();
    return frozen;
  };
  const auto moment = [](int second) {
    return Moment{static_cast<IntervalNumber>(second - 1), std::chrono::seconds(second), {}};
  };
  for (std::uint64_t slave = 0; slave < 32; ++slave) tap.fault(FlightReason::slave_lost, slave, moment(10));
  EXPECT_TRUE(recorded_at(10)) << "a cable with all slaves";
  tap.fault(FlightReason::bus_off, 0, moment(600));
  EXPECT_TRUE(recorded_at(600)) << "it has left room for other faults of the hour";
}

TEST(Flight, WhatCouldNotBeWrittenIsTriedWithTheNextFault) {
  rt::FlightRecorder recorder(256, 0);
  FlightTap tap(recorder, {});
  for (const int second : {1, 2}) {
    const Moment when{static_cast<IntervalNumber>(second), std::chrono::seconds(second), {}};
    tap.fault(FlightReason::bus_off, 0, when);
    tap.at(when);
    ASSERT_TRUE(recorder.wait_frozen(milliseconds(0))) << second;
    recorder.not_saved();
    recorder.rearm();
  }
}

TEST(Flight, AFaultThatComesAgainAndAgainIsRecordedTwiceAnHour) {
  Faults faults;
  std::vector<int> each_two_minutes;
  for (int second = 0; second < 24 * 3600; second += 120) each_two_minutes.push_back(second);
  const auto recorded = faults.recorded_of(each_two_minutes, FlightReason::sending_failed);
  EXPECT_EQ(recorded.size(), 48U);
  EXPECT_EQ((std::vector<int>(recorded.begin(), recorded.begin() + 4)),
            (std::vector<int>{0, 120, 3600, 3720}));
}

TEST(Flight, AFaultWhileTheOneBeforeIsSavedBeginsWithTheNext) {
  rt::FlightRecorder recorder(256, 0);
  FlightTap tap(recorder, {});
  const auto fault = [&](int second, FlightReason reason) {
    const Moment when{static_cast<IntervalNumber>(second), std::chrono::seconds(second), {}};
    tap.fault(reason, 0, when);
    tap.at(when);
  };
  fault(1, FlightReason::bus_off);
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  fault(2, FlightReason::slave_lost);
  recorder.rearm();
  fault(3, FlightReason::slave_lost);
  ASSERT_TRUE(recorder.wait_frozen(milliseconds(0)));
  EXPECT_EQ(recorder.trigger().reason, static_cast<std::uint32_t>(FlightReason::slave_lost));
  EXPECT_EQ(recorder.trigger().interval, 3U);
}

TEST(Flight, OnlyTheFaultsThatAreWantedAreRecorded) {
  FlightTriggers none{false, 0, false, false, false};
  Flight flight(1024, 0, none);
  flight.rig.at(100, can::Time{0}, [&] { flight.rig.bus.send_result = can::SendResult::queue_full; });
  const can::Time late_edge = flight.rig.first_sync() + 110 * flight.rig.interval;
  flight.rig.bus.lateness = [&](can::Time deadline) {
    return deadline == late_edge ? 50 * flight.rig.interval : can::Time{0};
  };
  flight.run_until(300);
  EXPECT_FALSE(flight.recorder.wait_frozen(milliseconds(0)));
}

}  // namespace
