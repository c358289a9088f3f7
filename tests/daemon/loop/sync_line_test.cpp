// The realtime loop on a scripted bus with a SYNC line on scripted devices, in virtual time.
#include "daemon/loop/sync_line.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "daemon/cansync/realtime/realtime_loop.h"
#include "support/loop_rig.h"
#include "sync/fake_system.h"
#include "sync/software_sync.h"

namespace {

using namespace cansyncd;
using namespace cansyncd::test;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;
using sync_line::LockState;
using sync_line::test::FakeSystem;

constexpr can::Time kInterval = milliseconds(1);

DaemonConfig config_with(const SyncConfig& sync) {
  DaemonConfig config;
  config.sync = sync;
  return config;
}

LoopSettings settings_with(SyncLine& line) {
  LoopSettings settings = virtual_time();
  settings.sync_line = &line;
  return settings;
}

/// The fake kernel's clock is the bus's, a fixed time apart.
constexpr can::Time kApart = -seconds(77);

/// A loop with a SYNC line, and somebody who makes edges at whole intervals plus `phase`.
struct SyncRig {
  explicit SyncRig(const SyncConfig& sync)
      : line(config_with(sync), kInterval, system), rig(settings_with(line)) {
    rig.bus.on_sleep = [this, play = rig.bus.on_sleep](can::Time now) {
      tick(now);
      play(now);
    };
    tick(rig.bus.now());
  }

  /// Lets the input's edges up to `now` happen.
  void tick(can::Time now) {
    // A wake-up may lie ahead of this sleep; edges are given with their own time stamps.
    system.now = now - kApart;
    if (!make_edge) return;
    const double length = 1e6 * (1.0 + drift);
    while (true) {
      const can::Time ideal =
          rig.first_sync() + phase + nanoseconds(std::llround(static_cast<double>(made) * length));
      if (ideal > now) return;
      ++made;
      if (present) make_edge(ideal);
    }
  }
  void gpio_edges() {
    make_edge = [this](can::Time at) { system.edge_at(at - kApart + jitter()); };
  }
  /// The SYNC edges from number `from` on, as distances from the nearest edge of the input, in ns.
  std::vector<double> errors(std::size_t from) const {
    std::vector<double> out;
    const double length = 1e6 * (1.0 + drift);
    for (std::size_t i = from; i < rig.bus.edges.size(); ++i) {
      const can::Time since = rig.bus.edges[i].first - rig.first_sync() - phase;
      out.push_back(std::remainder(static_cast<double>(since.count()), length));
    }
    return out;
  }
  std::vector<LockState> states() const {
    std::vector<LockState> out;
    for (const auto& change : rig.reported<SyncSourceChanged>()) out.push_back(change.to);
    return out;
  }

  FakeSystem system;
  SyncLine line;
  LoopRig rig;
  can::Time phase{0};
  double drift = 0;
  bool present = true;
  std::function<can::Time()> jitter = [] { return can::Time{0}; };
  std::function<void(can::Time)> make_edge;
  std::uint64_t made = 0;
};

SyncConfig input(SyncInput kind) {
  SyncConfig sync;
  sync.input = kind;
  return sync;
}

SyncConfig output(SyncOutput kind) {
  SyncConfig sync;
  sync.output = kind;
  return sync;
}

void expect_edges_apart(const SyncRig& rig) {
  can::Time before{0};
  for (const auto& [due, produced] : rig.rig.bus.edges) {
    ASSERT_GE(produced - before, kInterval / 2) << "two edges in a bunch";
    before = produced;
  }
}

// --- inputs

TEST(SyncInput, TheTimelineMovesToAnEdgeAndStaysThere) {
  SyncRig rig(input(SyncInput::gpio));
  rig.phase = microseconds(300);
  rig.drift = 40e-6;
  rig.gpio_edges();
  rig.rig.run_until(3000);
  for (const double error : rig.errors(2000)) ASSERT_LT(std::abs(error), 150.0) << "ns";
  EXPECT_EQ(rig.states(), std::vector<LockState>{LockState::locked});
  const auto snapshot = rig.rig.snapshot();
  EXPECT_EQ(snapshot.sync.state, LockState::locked);
  EXPECT_GT(snapshot.sync.edges, 2900U);
  EXPECT_EQ(snapshot.missed_syncs, 0U);
  expect_edges_apart(rig);
}

TEST(SyncInput, TelegramsKeepTheirSlotsAfterTheMovingEdge) {
  SyncRig rig(input(SyncInput::gpio));
  rig.phase = microseconds(-200);
  std::mt19937 random(4);
  std::uniform_int_distribution<int> noise(-10'000, 10'000);
  rig.jitter = [&] { return nanoseconds(noise(random)); };
  rig.gpio_edges();
  cansync::ReferenceUpdate update;
  update.valid_mask = 1;
  update.release_intervals = 1000;
  rig.rig.push_at(60, update);
  rig.rig.run_until(900);
  const auto& times = cansync::slot_times(cansync::BitRate::mbit1);
  unsigned seen = 0;
  for (const auto& sent : rig.rig.bus.sent) {
    if ((sent.frame.id & 0x780U) != cansync::identifier::reference_one) continue;
    const auto after = std::find_if(rig.rig.bus.edges.rbegin(), rig.rig.bus.edges.rend(),
                                    [&](const auto& edge) { return edge.first <= sent.at; });
    ASSERT_EQ(sent.at - after->first, times.reference_one - microseconds(50));
    ++seen;
  }
  EXPECT_GT(seen, 800U);
  EXPECT_EQ(rig.rig.snapshot().counters.left_out, 0U);
}

TEST(SyncInput, MissingEdgesAreHeldOverAndToldOnTheEdge) {
  SyncConfig sync = input(SyncInput::gpio);
  sync.holdover = milliseconds(200);
  SyncRig rig(sync);
  rig.phase = microseconds(20);
  rig.gpio_edges();
  rig.rig.at(500, microseconds(0), [&] { rig.present = false; });
  rig.rig.at(600, microseconds(0), [&] { rig.present = true; });
  rig.rig.at(800, microseconds(0), [&] { rig.present = false; });
  rig.rig.at(1200, microseconds(0), [&] {
    const auto latest = rig.rig.snapshot().sync;
    EXPECT_EQ(latest.state, LockState::lost);
    EXPECT_GT(latest.holdover, can::Time(milliseconds(300)));
    rig.present = true;
  });
  rig.rig.run_until(1500);
  EXPECT_EQ(rig.states(), (std::vector<LockState>{LockState::locked, LockState::holdover, LockState::locked,
                                                  LockState::holdover, LockState::lost, LockState::searching,
                                                  LockState::locked}));
  const auto changes = rig.rig.reported<SyncSourceChanged>();
  EXPECT_NEAR(static_cast<double>(changes[2].missing.count()), 100e6, 3e6) << "how long";
  for (const double error : rig.errors(200)) ASSERT_LT(std::abs(error), 1000.0) << "the period is kept";
  EXPECT_EQ(rig.rig.snapshot().missed_syncs, 0U);
}

TEST(SyncInput, AStallIsSkippedAndCountedWhileFollowing) {
  SyncRig rig(input(SyncInput::gpio));
  rig.drift = -80e-6;
  rig.phase = microseconds(30);
  rig.gpio_edges();
  bool stalled = false;
  rig.rig.bus.lateness = [&](can::Time deadline) {
    const bool now = !stalled && deadline > rig.rig.first_sync() + 1000 * kInterval;
    if (!now) return can::Time{0};
    stalled = true;
    return can::Time(microseconds(7600));
  };
  rig.rig.run_until(2000);
  expect_edges_apart(rig);
  const auto missed = rig.rig.reported<SyncsMissed>();
  ASSERT_EQ(missed.size(), 1U);
  EXPECT_GE(missed[0].count, 7U);
  EXPECT_EQ(rig.rig.snapshot().missed_syncs, missed[0].count);
  for (const double error : rig.errors(1900)) ASSERT_LT(std::abs(error), 200.0);
}

TEST(SyncInput, PulsesPerSecondGiveThePhase) {
  SyncRig rig(input(SyncInput::pps));
  rig.phase = microseconds(150);
  rig.drift = 20e-6;
  rig.make_edge = [&](can::Time at) {
    if ((rig.made - 1) % 1000 == 0) rig.system.pulse_at(at - kApart);
  };
  rig.rig.run_until(15'000);
  const auto sync = rig.rig.snapshot().sync;
  EXPECT_EQ(sync.state, LockState::locked);
  EXPECT_GE(sync.edges, 12U);
  for (const double error : rig.errors(14'000)) ASSERT_LT(std::abs(error), 500.0) << "ns";
}

TEST(SyncInput, ASoftwareSyncFrameIsAnEdgeAndNoneOfTheMastersBusiness) {
  SyncRig rig(input(SyncInput::can));
  rig.phase = microseconds(-100);
  const can::Frame frame = sync_line::software_sync(0x80);
  const can::Time length = microseconds(can::frame_bits(frame) - can::kInterframeBits);
  rig.make_edge = [&](can::Time at) { rig.rig.bus.put(frame, at + length); };
  rig.rig.run_until(2000);
  const auto snapshot = rig.rig.snapshot();
  EXPECT_EQ(snapshot.sync.state, LockState::locked);
  for (const double error : rig.errors(1900)) ASSERT_LT(std::abs(error), 50.0) << "the frame's beginning";
  for (const auto rejected : snapshot.counters.rejected) EXPECT_EQ(rejected, 0U);
}

TEST(SyncInput, TheOffsetSetsTheEdgesApart) {
  SyncConfig sync = input(SyncInput::gpio);
  sync.input_offset = microseconds(40);
  SyncRig rig(sync);
  rig.gpio_edges();
  rig.rig.run_until(1000);
  EXPECT_NEAR(rig.errors(999).front(), 40'000.0, 20.0);
}

TEST(SyncInput, AFailingDeviceIsToldOnTheEdge) {
  SyncRig rig(input(SyncInput::gpio));
  rig.gpio_edges();
  rig.rig.at(300, microseconds(0), [&] { rig.system.read_error = ENODEV; });
  rig.rig.at(400, microseconds(0), [&] { rig.system.read_error = 0; });
  rig.rig.run_until(500);
  const auto changes = rig.rig.reported<SyncDeviceChanged>();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_FALSE(changes[0].output);
  EXPECT_EQ(changes[0].error, ENODEV);
  EXPECT_EQ(changes[1].error, 0);
}

// --- outputs

TEST(SyncOutput, AGpioPulseBeginsAtTheEdgeAndEndsBeforeTheFirstTelegram) {
  SyncRig rig(output(SyncOutput::gpio));
  rig.rig.run_until(500);
  ASSERT_GE(rig.system.levels.size(), 2 * 498U);
  std::size_t pulses = 0;
  for (std::size_t i = 0; i < rig.system.levels.size(); ++i) {
    EXPECT_EQ(rig.system.levels[i].second, i % 2 == 0) << "begins, ends, begins ...";
    if (rig.system.levels[i].second) ++pulses;
  }
  EXPECT_EQ(pulses, rig.rig.bus.edges.size());
  EXPECT_FALSE(rig.system.levels.back().second) << "idle at the end";
  for (std::size_t i = 0; i < rig.rig.bus.edges.size(); ++i) {
    ASSERT_EQ(rig.rig.bus.edges[i].first, rig.rig.first_sync() +
                                              (rig.rig.bus.edges[0].first - rig.rig.first_sync()) +
                                              static_cast<int>(i) * kInterval)
        << "an output alone does not move the timeline";
  }
}

TEST(SyncOutput, WithoutSyncThereIsNoPulse) {
  FakeSystem system;
  SyncLine line(config_with(output(SyncOutput::gpio)), kInterval, system);
  LoopSettings settings = virtual_time(StartTarget::none);
  settings.sync_line = &line;
  LoopRig rig(settings);
  rig.run_until(50);
  EXPECT_TRUE(system.levels.empty());
}

TEST(SyncOutput, AFailingLineIsCountedAndToldOnce) {
  SyncRig rig(output(SyncOutput::gpio));
  rig.rig.at(100, microseconds(0), [&] { rig.system.control_error[GPIO_V2_LINE_SET_VALUES_IOCTL] = EIO; });
  rig.rig.at(150, microseconds(0), [&] { rig.system.control_error.clear(); });
  rig.rig.run_until(200);
  const auto changes = rig.rig.reported<SyncDeviceChanged>();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_TRUE(changes[0].output);
  EXPECT_EQ(changes[0].error, EIO);
  EXPECT_EQ(changes[1].error, 0);
  EXPECT_GE(changes[1].failures, 49U);
  EXPECT_LE(changes[1].failures, 51U);
  EXPECT_EQ(rig.rig.snapshot().sync.output_failures, changes[1].failures);
}

TEST(SyncOutput, TheSoftwareFrameIsSentRightAtTheEdge) {
  SyncRig rig(output(SyncOutput::can));
  rig.rig.run_until(300);
  std::vector<can::Time> sent;
  for (const auto& frame : rig.rig.bus.sent) {
    if (sync_line::is_software_sync(frame.frame, 0x80)) sent.push_back(frame.at);
  }
  ASSERT_EQ(sent.size(), rig.rig.bus.edges.size());
  for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_EQ(sent[i], rig.rig.bus.edges[i].second);
  for (const auto rejected : rig.rig.snapshot().counters.rejected) EXPECT_EQ(rejected, 0U) << "its echo";
}

TEST(SyncOutput, AFrameTheBusDoesNotTakeIsCounted) {
  SyncRig rig(output(SyncOutput::can));
  rig.rig.at(100, microseconds(0), [&] { rig.rig.bus.send_result = can::SendResult::queue_full; });
  rig.rig.at(110, microseconds(0), [&] { rig.rig.bus.send_result = can::SendResult::queued; });
  rig.rig.run_until(150);
  const auto changes = rig.rig.reported<SyncDeviceChanged>();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].error, SyncLine::kNotSent);
  EXPECT_GE(rig.rig.snapshot().sync.output_failures, 9U);
}

TEST(SyncOutput, TheTimelineFollowsTheHardwareClock) {
  FakeSystem system;
  system.hardware_rate = 1.0 - 70e-6;
  const SyncConfig sync = output(SyncOutput::phc);
  sync_line::PhcPin pin;
  sync_line::PhcOutput clock(system, pin, kInterval);
  // The loop's own timeline beside a clock read ten times a second.
  Timeline timeline(kInterval, sync_line::PhaseLockSettings{});
  timeline.begin(system.now + microseconds(700));
  can::Time next_reading = system.now;
  double worst = 0;
  for (int i = 0; i < 10'000; ++i) {
    system.now = timeline.due();
    timeline.advance();
    if (system.now >= next_reading) {
      clock.step();
      next_reading += sync_line::PhcOutput::kPeriod;
    }
    can::Time at{0};
    while (clock.take(timeline.lock()->next(), at)) timeline.lock()->input(at);
    if (i < 2000) continue;
    const can::Time hardware = system.hardware_at(timeline.due());
    worst = std::max(worst, std::abs(std::remainder(static_cast<double>(hardware.count()), 1e6)));
  }
  EXPECT_EQ(timeline.lock()->state(), LockState::locked);
  EXPECT_LT(worst, 100.0) << "ns between the hardware's edge and the timeline's";
}

TEST(SyncOutput, TheHardwareClockIsSwitchedWithSync) {
  SyncRig rig(output(SyncOutput::phc));
  can::Time next_reading = rig.rig.bus.now();
  rig.rig.bus.on_sleep = [&, play = rig.rig.bus.on_sleep](can::Time now) {
    play(now);
    if (now < next_reading) return;
    rig.line.clock()->step();
    next_reading += sync_line::PhcOutput::kPeriod;
  };
  rig.rig.at(800, microseconds(0), [&] { EXPECT_EQ(rig.system.periodic.size(), 2U) << "on with set-up"; });
  rig.rig.push_at(1000, ModeRequest{1, Mode::stop, false});
  rig.rig.run_until(1500);
  ASSERT_EQ(rig.system.periodic.size(), 3U);
  EXPECT_EQ(rig.system.periodic[0].period.nsec, 0U) << "off at the start, whoever has left it on";
  EXPECT_GT(rig.system.periodic[1].period.nsec, 0U);
  EXPECT_EQ(rig.system.periodic[2].period.nsec, 0U) << "off with the mode command stop";
  EXPECT_EQ(rig.rig.snapshot().sync.state, LockState::locked);
}

// --- the timeline by itself

TEST(Timeline, WithoutAnInputItIsTheAbsoluteGrid) {
  Timeline timeline(kInterval, std::nullopt);
  timeline.begin(seconds(3));
  for (int n = 0; n < 100; ++n) {
    EXPECT_EQ(timeline.due(), can::Time(seconds(3)) + n * kInterval);
    EXPECT_EQ(timeline.next(), static_cast<cansync::IntervalNumber>(n));
    timeline.advance();
  }
  EXPECT_EQ(timeline.lock(), nullptr);
}

TEST(Timeline, SkipsByTheHalfIntervalRule) {
  for (int late = 0; late < 5000; late += 50) {
    Timeline timeline(kInterval, std::nullopt);
    timeline.begin(seconds(3));
    const can::Time now = can::Time(seconds(3)) + microseconds(late);
    const Timeline::Missed missed = timeline.skip_missed(now);
    EXPECT_LE(now - timeline.due(), kInterval / 2) << late;
    EXPECT_GT(now - timeline.due(), -kInterval / 2) << late;
    EXPECT_EQ(missed.wait, timeline.due() > now) << late;
    EXPECT_EQ(timeline.next(), missed.count);
  }
}

}  // namespace
