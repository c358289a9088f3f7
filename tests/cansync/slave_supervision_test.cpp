// What a slave supervises: rows S6, S10, S11 and S12 of docs/cansync-slave.md, at all four intervals.
#include "cansync/slave/slave_supervision.h"

#include <gtest/gtest.h>

#include <chrono>

#include "cansync/settings/timing.h"

namespace cansync::test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

class SupervisionOfSlave : public ::testing::TestWithParam<BitRate> {
 protected:
  static constexpr unsigned kEdges = 5;
  static constexpr unsigned kMisses = 4;

  static SlaveSupervisionSettings settings() {
    SlaveSupervisionSettings result;
    result.interval = slot_times(GetParam()).interval;
    result.lock_time = result.interval * 20;
    result.edges_until_fault = kEdges;
    result.misses_until_fault = kMisses;
    result.on_sync_lost = SlaveReaction::pulse_inhibit;
    result.on_references_missing = SlaveReaction::quick_stop;
    return result;
  }
  /// The next edge that comes; `away` edges stay away before it.
  std::uint32_t edge(unsigned away = 0) {
    now_ += settings().interval * (away + 1);
    return supervision_.edge(now_, activated_);
  }
  void lock() {
    for (int i = 0; i < 21; ++i) edge();
    ASSERT_TRUE(supervision_.synchronized());
  }

  SlaveSupervision supervision_{settings()};
  Duration now_ = std::chrono::seconds(7);
  bool activated_ = true;
};

TEST_P(SupervisionOfSlave, S6Bit15IsSetWhenLocked) {
  activated_ = false;
  for (int i = 0; i < 100; ++i) edge();
  EXPECT_EQ(supervision_.status_word(0xFFFF), 0x7FFF) << "not before it is activated";
  activated_ = true;
  for (int i = 0; i < 20; ++i) edge();
  EXPECT_EQ(supervision_.status_word(0x0007), 0x0007);
  edge();
  EXPECT_EQ(supervision_.status_word(0x0007), 0x8007);
}

TEST_P(SupervisionOfSlave, S10OneMissingEdgeIsRunThrough) {
  lock();
  EXPECT_EQ(edge(1), 2u) << "two intervals have passed";
  EXPECT_TRUE(supervision_.synchronized());
  EXPECT_EQ(supervision_.missed_edges(), 1u);
  EXPECT_EQ(supervision_.take_fault(), SlaveFault::none);
}

TEST_P(SupervisionOfSlave, S11OneEdgeLessThanTheLimitIsRunThroughTheLimitIsAFault) {
  lock();
  edge(kEdges - 1);
  EXPECT_TRUE(supervision_.synchronized());
  edge(kEdges);
  EXPECT_FALSE(supervision_.synchronized());
  EXPECT_EQ(supervision_.fault(), SlaveFault::sync_lost);
  EXPECT_EQ(supervision_.reaction(), SlaveReaction::pulse_inhibit);
  EXPECT_EQ(supervision_.take_fault(), SlaveFault::sync_lost);
  EXPECT_EQ(supervision_.take_fault(), SlaveFault::none) << "told once";
  EXPECT_EQ(supervision_.status_word(0x8001), 0x0001);
  for (int i = 0; i < 21; ++i) edge();
  EXPECT_TRUE(supervision_.synchronized()) << "edges have come for the lock time again";
  EXPECT_EQ(supervision_.fault(), SlaveFault::sync_lost) << "until it is acknowledged";
  supervision_.acknowledge();
  EXPECT_EQ(supervision_.fault(), SlaveFault::none);
  EXPECT_EQ(supervision_.reaction(), SlaveReaction::report);
}

TEST_P(SupervisionOfSlave, S11SilenceIsNoticedBeforeTheNextEdge) {
  lock();
  const Duration interval = settings().interval;
  supervision_.check(now_ + interval * kEdges);
  EXPECT_TRUE(supervision_.synchronized());
  supervision_.check(now_ + interval * (kEdges + 1));
  EXPECT_FALSE(supervision_.synchronized());
  EXPECT_EQ(supervision_.take_fault(), SlaveFault::sync_lost);
}

TEST_P(SupervisionOfSlave, S11BeforeItIsSynchronizedNothingIsLost) {
  for (int i = 0; i < 10; ++i) edge();
  edge(kEdges + 3);
  EXPECT_EQ(supervision_.take_fault(), SlaveFault::none);
  for (int i = 0; i < 19; ++i) edge();
  EXPECT_FALSE(supervision_.synchronized()) << "the lock time began anew";
}

TEST_P(SupervisionOfSlave, S12MissingReferencesUpToTheLimit) {
  supervision_.references(1, false);
  EXPECT_EQ(supervision_.missed_references(), 0u) << "before the first none is missing";
  supervision_.references(1, true);
  EXPECT_FALSE(supervision_.extrapolating());
  for (unsigned i = 1; i < kMisses; ++i) {
    EXPECT_EQ(supervision_.references(1, false), 1u);
    EXPECT_TRUE(supervision_.extrapolating());
    EXPECT_EQ(supervision_.misses(), i);
  }
  EXPECT_EQ(supervision_.fault(), SlaveFault::none);
  supervision_.references(1, true);
  EXPECT_FALSE(supervision_.extrapolating()) << "it came again";
  EXPECT_EQ(supervision_.misses(), 0u);
  for (unsigned i = 0; i < kMisses; ++i) supervision_.references(1, false);
  EXPECT_EQ(supervision_.fault(), SlaveFault::references_missing);
  EXPECT_EQ(supervision_.reaction(), SlaveReaction::quick_stop);
  EXPECT_FALSE(supervision_.extrapolating()) << "the fault is what counts";
  EXPECT_EQ(supervision_.missed_references(), 2 * kMisses - 1);
}

TEST_P(SupervisionOfSlave, S12IntervalsWithoutAnEdgeAreWithoutAReferenceToo) {
  supervision_.references(1, true);
  EXPECT_EQ(supervision_.references(3, true), 2u) << "the last of the three brought one";
  EXPECT_EQ(supervision_.missed_references(), 2u);
  EXPECT_EQ(supervision_.references(0, false), 0u) << "an edge out of turn";
  EXPECT_EQ(supervision_.references(1'000'000, false), SlaveSupervision::kMostMissing);
}

TEST_P(SupervisionOfSlave, S12WithoutALimitNothingIsAFault) {
  SlaveSupervisionSettings never = settings();
  never.misses_until_fault = 0;
  supervision_ = SlaveSupervision(never);
  supervision_.references(1, true);
  for (int i = 0; i < 1000; ++i) supervision_.references(1, false);
  EXPECT_EQ(supervision_.fault(), SlaveFault::none);
  EXPECT_EQ(supervision_.misses(), 1000u);
}

TEST_P(SupervisionOfSlave, S11OfTwoFaultsTheGraverIsShownAndEachEndsByItself) {
  for (const bool sync_lost_first : {true, false}) {
    supervision_ = SlaveSupervision(settings());
    lock();
    supervision_.references(1, true);
    if (!sync_lost_first) supervision_.references(kMisses, false);
    edge(kEdges);
    if (sync_lost_first) supervision_.references(kMisses, false);
    EXPECT_EQ(supervision_.fault(), SlaveFault::sync_lost);
    EXPECT_EQ(supervision_.reaction(), SlaveReaction::pulse_inhibit);
    EXPECT_EQ(supervision_.take_fault(), SlaveFault::sync_lost);
    EXPECT_EQ(supervision_.take_fault(), SlaveFault::references_missing) << "each is told";
    EXPECT_EQ(supervision_.take_fault(), SlaveFault::none);
    const bool first = sync_lost_first;
    supervision_.acknowledge(first ? SlaveFault::sync_lost : SlaveFault::references_missing);
    EXPECT_EQ(supervision_.fault(), first ? SlaveFault::references_missing : SlaveFault::sync_lost);
    EXPECT_EQ(supervision_.reaction(), first ? SlaveReaction::quick_stop : SlaveReaction::pulse_inhibit);
    supervision_.acknowledge();
    EXPECT_EQ(supervision_.fault(), SlaveFault::none);
  }
}

TEST_P(SupervisionOfSlave, S11OfTwoReactionsTheStrongerIsShown) {
  SlaveSupervisionSettings other = settings();
  other.on_sync_lost = SlaveReaction::report;
  supervision_ = SlaveSupervision(other);
  lock();
  supervision_.references(1, true);
  supervision_.references(kMisses, false);
  edge(kEdges);
  EXPECT_EQ(supervision_.fault(), SlaveFault::sync_lost);
  EXPECT_EQ(supervision_.reaction(), SlaveReaction::quick_stop);
  EXPECT_EQ(supervision_.reaction_to(SlaveFault::sync_lost), SlaveReaction::report);
}

INSTANTIATE_TEST_SUITE_P(AllBitRates, SupervisionOfSlave,
                         ::testing::Values(BitRate::kbit125, BitRate::kbit250, BitRate::kbit500,
                                           BitRate::mbit1));

}  // namespace
}  // namespace cansync::test
