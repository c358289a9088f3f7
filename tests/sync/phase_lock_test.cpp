#include "sync/phase_lock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace {

using namespace sync_line;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

constexpr Time kInterval = milliseconds(1);

PhaseLockSettings settings(std::uint32_t spacing = 1) {
  PhaseLockSettings out;
  out.spacing = spacing;
  return out;
}

/// An input whose edges stand `phase` after a grid, `drift` parts longer apart than nominal, in virtual time.
class Rig {
 public:
  explicit Rig(const PhaseLockSettings& lock_settings, Time phase = Time{0}, double drift = 0)
      : lock(lock_settings), spacing_(lock_settings.spacing), phase_(phase), drift_(drift) {
    lock.begin(Time(seconds(1)));
  }

  PhaseLock lock;
  std::function<Time()> jitter = [] { return Time{0}; };
  bool present = true;
  std::vector<double> error;    ///< true distance of each timeline edge from the input's ideal edge, in ns
  std::vector<Time> distances;  ///< between the timeline's edges

  Time ideal(std::uint64_t n) const {
    const double length = static_cast<double>(kInterval.count()) * (1.0 + drift_);
    return Time(seconds(1)) + phase_ + Time(std::llround(static_cast<double>(n) * length));
  }
  /// One interval of the timeline: its edge passes, and the input's edges up to the next one arrive.
  void step() {
    const Time edge = lock.next();
    const double length = static_cast<double>(kInterval.count()) * (1.0 + drift_);
    error.push_back(std::remainder(static_cast<double>((edge - ideal(0)).count()), length));
    lock.advance();
    distances.push_back(lock.next() - edge);
    const Time until = edge + kInterval * 3 / 4;
    while (ideal(input_) <= until) {
      const bool counts = input_ % spacing_ == 0;
      if (counts && present) lock.input(ideal(input_) + jitter());
      ++input_;
    }
  }
  void run(unsigned intervals) {
    for (unsigned i = 0; i < intervals; ++i) step();
  }
  /// Intervals until the lock says so; `limit` when it does not.
  unsigned until(LockState state, unsigned limit) {
    for (unsigned i = 0; i < limit; ++i) {
      if (lock.state() == state) return i;
      step();
    }
    return limit;
  }
  double worst_error_since(std::size_t first) const {
    double worst = 0;
    for (std::size_t i = first; i < error.size(); ++i) worst = std::max(worst, std::abs(error[i]));
    return worst;
  }

 private:
  const std::uint64_t spacing_;
  const Time phase_;
  const double drift_;
  std::uint64_t input_ = 0;
};

void expect_no_interval_beyond(const Rig& rig, Time step) {
  for (std::size_t i = 0; i < rig.distances.size(); ++i) {
    ASSERT_LE(std::chrono::abs(rig.distances[i] - kInterval), step) << "interval " << i;
  }
}

double deviation(const std::vector<double>& values, std::size_t first) {
  double sum = 0;
  double squares = 0;
  for (std::size_t i = first; i < values.size(); ++i) {
    sum += values[i];
    squares += values[i] * values[i];
  }
  const auto n = static_cast<double>(values.size() - first);
  return std::sqrt(squares / n - sum / n * sum / n);
}

TEST(PhaseLock, WithoutInputEveryIntervalIsNominal) {
  Rig rig(settings());
  rig.present = false;
  rig.run(1000);
  EXPECT_EQ(rig.lock.next(), Time(seconds(1)) + 1000 * kInterval);
  EXPECT_EQ(rig.lock.state(), LockState::searching);
  EXPECT_EQ(rig.lock.holdover(), Time{0});
}

TEST(PhaseLock, LocksFromAnyPhaseWithinTheTimeTheStepAllows) {
  for (int phase = -500; phase <= 500; phase += 20) {
    Rig rig(settings(), microseconds(phase));
    const unsigned needed = rig.until(LockState::locked, 2000);
    // Half an interval at 1 us per interval, then the filter.
    EXPECT_LE(needed, static_cast<unsigned>(std::abs(phase)) + 60U) << phase;
    rig.run(400);
    EXPECT_LT(std::abs(rig.error.back()), 50.0) << phase;
    expect_no_interval_beyond(rig, microseconds(1));
  }
}

TEST(PhaseLock, NoiseAtHalfAnIntervalDoesNotTurnTheSearchRound) {
  Rig rig(settings(), microseconds(500));
  std::mt19937 random(1);
  std::uniform_int_distribution<int> noise(-30'000, 30'000);
  rig.jitter = [&] { return nanoseconds(noise(random)); };
  EXPECT_LE(rig.until(LockState::locked, 2000), 800U);
}

/// As a software SYNC frame of a master whose thread wakes up late, again and again.
TEST(PhaseLock, ASearchSurvivesEdgesThatAreLateByUpToHalfAnInterval) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Rig rig(settings(), microseconds(350));
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> late(100'000, 490'000);
    rig.jitter = [&] { return nanoseconds(random() % 4 == 0 ? late(random) : 0); };
    unsigned needed = 0;
    for (; needed < 3000 && rig.lock.state() != LockState::locked; ++needed) {
      rig.step();
      ASSERT_LE(std::chrono::abs(rig.lock.phase_error()), kInterval) << seed;
    }
    EXPECT_LT(needed, 2500U) << seed;
    EXPECT_LT(std::abs(rig.error.back()), 20'000.0) << seed;
  }
}

TEST(PhaseLock, DoesNotLockToEdgesThatStandAnywhere) {
  Rig rig(settings());
  std::mt19937 random(3);
  std::uniform_int_distribution<int> anywhere(-250'000, 250'000);
  rig.jitter = [&] { return nanoseconds(anywhere(random)); };
  EXPECT_EQ(rig.until(LockState::locked, 5000), 5000U);
}

TEST(PhaseLock, FiltersTheInputsJitter) {
  Rig rig(settings(), microseconds(3));
  std::mt19937 random(2);
  std::uniform_int_distribution<int> noise(-20'000, 20'000);
  std::vector<double> input;
  rig.jitter = [&] {
    input.push_back(noise(random));
    return nanoseconds(static_cast<long>(input.back()));
  };
  rig.run(6000);
  ASSERT_EQ(rig.lock.state(), LockState::locked);
  const double ratio = deviation(rig.error, 1000) / deviation(input, 1000);
  RecordProperty("output_to_input_spread_permille", static_cast<int>(ratio * 1000));
  EXPECT_LT(ratio, 0.25);
  EXPECT_LT(rig.worst_error_since(1000), 15'000.0) << "the input goes to 20 us";
}

class Drifts : public testing::TestWithParam<double> {};

TEST_P(Drifts, AreFollowedWithoutAGrowingError) {
  Rig rig(settings(), microseconds(40), GetParam());
  rig.run(10'000);
  EXPECT_EQ(rig.lock.state(), LockState::locked);
  EXPECT_LT(rig.worst_error_since(1500), 200.0);
  EXPECT_LT(rig.worst_error_since(9000), 20.0) << "ns after ten seconds; free running: 1 ms";
  EXPECT_EQ(rig.lock.counters().rejected, 0U);
  EXPECT_NEAR(rig.lock.period(), 1e6 * (1.0 + GetParam()), 1.0);
  expect_no_interval_beyond(rig, microseconds(1));
}

INSTANTIATE_TEST_SUITE_P(PhaseLock, Drifts, testing::Values(-100e-6, -20e-6, 0.0, 20e-6, 100e-6));

TEST(PhaseLock, MissingEdgesAreRiddenThroughWithTheLearnedPeriod) {
  Rig rig(settings(), microseconds(10), 100e-6);
  rig.run(3000);
  ASSERT_EQ(rig.lock.state(), LockState::locked);
  rig.present = false;
  rig.run(3);
  EXPECT_EQ(rig.lock.state(), LockState::holdover);
  rig.run(900);
  EXPECT_EQ(rig.lock.state(), LockState::holdover);
  EXPECT_LT(std::abs(rig.error.back()), 1000.0) << "a free timeline would be 90 us off";
  EXPECT_NEAR(static_cast<double>(rig.lock.holdover().count()), 903e6, 2e6);
  rig.present = true;
  EXPECT_LE(rig.until(LockState::locked, 10), 2U);
  EXPECT_EQ(rig.lock.holdover(), Time{0});
}

TEST(PhaseLock, IsLostAfterTheHoldOverTimeAndFindsBack) {
  Rig rig(settings(), microseconds(10));
  rig.run(500);
  rig.present = false;
  rig.run(1010);
  EXPECT_EQ(rig.lock.state(), LockState::lost);
  EXPECT_GT(rig.lock.holdover(), Time(seconds(1)));
  const auto before = rig.distances.size();
  rig.run(1000);
  for (std::size_t i = before; i < rig.distances.size(); ++i) {
    ASSERT_LE(std::chrono::abs(rig.distances[i] - kInterval), nanoseconds(2)) << "goes on by itself";
  }
  rig.present = true;
  rig.step();
  rig.step();
  EXPECT_EQ(rig.lock.state(), LockState::searching);
  EXPECT_LE(rig.until(LockState::locked, 1000), 100U);
}

TEST(PhaseLock, AWildEdgeMovesNothing) {
  Rig rig(settings(), Time{0});
  rig.run(500);
  const double before = rig.error.back();
  rig.lock.input(rig.ideal(499) + microseconds(300));
  rig.run(20);
  EXPECT_NEAR(rig.error.back(), before, 2.0);
  EXPECT_EQ(rig.lock.state(), LockState::locked);
  EXPECT_EQ(rig.lock.counters().rejected, 1U);
}

TEST(PhaseLock, ABurstMovesNothing) {
  Rig rig(settings(), Time{0});
  rig.run(500);
  const auto accepted = rig.lock.counters().accepted;
  const Time edge = rig.ideal(500);
  for (int i = 1; i <= 100; ++i) rig.lock.input(edge + microseconds(4 * i));
  rig.run(5);
  EXPECT_LE(rig.lock.counters().accepted, accepted + 6);
  rig.run(100);
  EXPECT_EQ(rig.lock.state(), LockState::locked);
  expect_no_interval_beyond(rig, microseconds(1));
  EXPECT_LT(rig.worst_error_since(480), 5000.0);
}

TEST(PhaseLock, EdgesOutOfOrderAreRejected) {
  PhaseLock lock(settings());
  lock.begin(Time(seconds(1)));
  lock.input(Time(seconds(1)));
  lock.input(Time(seconds(1)));
  lock.input(Time(milliseconds(998)));
  EXPECT_EQ(lock.counters().accepted, 1U);
  EXPECT_EQ(lock.counters().rejected, 2U);
}

TEST(PhaseLock, AnInputThatJumpedIsSearchedAnew) {
  Rig rig(settings(), Time{0});
  rig.run(500);
  ASSERT_EQ(rig.lock.state(), LockState::locked);
  // The same lock, fed by an input a quarter of an interval later.
  Time edge = rig.lock.next() + microseconds(250);
  unsigned until_search = 0;
  while (rig.lock.state() != LockState::searching && until_search < 100) {
    rig.lock.advance();
    rig.lock.input(edge);
    edge += kInterval;
    ++until_search;
  }
  EXPECT_LE(until_search, 20U);
  for (int i = 0; i < 400; ++i) {
    const Time before = rig.lock.next();
    rig.lock.advance();
    ASSERT_LE(std::chrono::abs(rig.lock.next() - before - kInterval), Time(microseconds(1)));
    rig.lock.input(edge);
    edge += kInterval;
  }
  EXPECT_EQ(rig.lock.state(), LockState::locked);
}

TEST(PhaseLock, SkippedEdgesKeepThePeriod) {
  Rig rig(settings(), Time{0}, 50e-6);
  rig.run(3000);
  const Time before = rig.lock.next();
  rig.lock.advance(500);
  const double passed = static_cast<double>((rig.lock.next() - before).count());
  EXPECT_NEAR(passed, 500e6 * (1.0 + 50e-6), 1000.0);
}

// --- one pulse per second

class Pulses : public testing::TestWithParam<double> {};

TEST_P(Pulses, KeepThePhaseOfWholeIntervals) {
  for (const int phase : {-400, -60, 0, 300, 500}) {
    Rig rig(settings(1000), microseconds(phase), GetParam());
    EXPECT_LE(rig.until(LockState::locked, 20'000), 8000U) << phase;
    const std::size_t locked = rig.error.size();
    rig.run(20'000);
    EXPECT_EQ(rig.lock.state(), LockState::locked) << phase;
    EXPECT_LT(rig.worst_error_since(locked + 10'000), 1000.0) << phase;
    expect_no_interval_beyond(rig, microseconds(1));
  }
}

INSTANTIATE_TEST_SUITE_P(PhaseLock, Pulses, testing::Values(-100e-6, 0.0, 100e-6));

TEST(PhaseLock, AMissingPulseIsRiddenThrough) {
  PhaseLockSettings pulses = settings(1000);
  pulses.holdover = seconds(10);
  Rig rig(pulses, microseconds(20), 30e-6);
  rig.run(15'000);
  ASSERT_EQ(rig.lock.state(), LockState::locked);
  rig.present = false;
  rig.run(900);
  EXPECT_EQ(rig.lock.state(), LockState::locked) << "one may be late";
  rig.run(2200);
  EXPECT_EQ(rig.lock.state(), LockState::holdover);
  rig.run(10'000);
  EXPECT_EQ(rig.lock.state(), LockState::lost);
  EXPECT_LT(std::abs(rig.error.back()), 5000.0);
}

TEST(PhaseLock, StatesHaveNames) {
  EXPECT_STREQ(name(LockState::searching), "searching");
  EXPECT_STREQ(name(LockState::locked), "locked");
  EXPECT_STREQ(name(LockState::holdover), "holdover");
  EXPECT_STREQ(name(LockState::lost), "lost");
}

}  // namespace
