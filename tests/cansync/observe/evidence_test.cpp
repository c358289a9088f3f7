// Which protocol frames belong to, and whether time stamps are bunched: lines of several protocols, made here.
#include "cansync/observe/evidence.h"

#include <gtest/gtest.h>

#include <random>

#include "cansync/observe/census.h"
#include "cansync/observe/random_line.h"

namespace cansync::observe {
namespace {

can::Frame data_frame(std::uint32_t id, std::vector<std::uint8_t> bytes, bool extended = false) {
  can::Frame frame;
  frame.id = id;
  frame.extended = extended;
  frame.dlc = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

/// Frames at their times, SYNC frames as edges.
class Heard {
 public:
  void frame(int us, const can::Frame& frame) {
    const Duration at = std::chrono::microseconds(us);
    if (!frame.extended && frame.id == 0x080)
      taker_.sync(at, &frame);
    else
      taker_.frame(at, frame);
  }
  Census census() const { return taker_.census(); }
  LineKind kind() const { return census().evidence.kind(); }

 private:
  CensusTaker taker_;
};

TEST(Evidence, RandomLinesAreCansyncWithAndWithoutSyncEdges) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto line = support::random_line(seed, seed % 4 == 0);
    const auto recording = support::record(line, line.master);
    for (const bool edges : {true, false}) {
      CensusTaker taker;
      for (const auto& entry : recording.entries) {
        if (entry.frame) taker.frame(entry.start, *entry.frame);
        if (!entry.frame && edges) taker.sync(entry.start, nullptr);
      }
      const Census census = taker.census();
      EXPECT_EQ(census.evidence.kind(), LineKind::cansync) << seed << edges << census.evidence.confidence();
      EXPECT_FALSE(census.stamps.bunched()) << seed;
    }
  }
}

TEST(Evidence, NothingIsSilentAndLittleIsUnknown) {
  Heard heard;
  EXPECT_EQ(heard.kind(), LineKind::silent);
  heard.frame(0, data_frame(0x101, {1, 2}));
  EXPECT_EQ(heard.kind(), LineKind::unknown);
}

TEST(Evidence, SyncFramesAloneAreUnknown) {
  Heard heard;
  for (int i = 0; i < 1000; ++i) heard.frame(1000 * i, data_frame(0x080, {}));
  EXPECT_EQ(heard.kind(), LineKind::unknown);
}

TEST(Evidence, AMasterWhoseDrivesAreOffIsCansync) {
  Heard heard;
  for (int i = 0; i < 100; ++i) {
    heard.frame(1000 * i, data_frame(0x080, {}));
    heard.frame(1000 * i + 300, data_frame(0x101, {1, 0, 2, 0, 3, 0, 4, 0}));
  }
  EXPECT_EQ(heard.kind(), LineKind::cansync);
}

TEST(Evidence, A29BitLineOfParameterGroupsIsJ1939) {
  Heard heard;
  for (int i = 0; i < 200; ++i) {
    heard.frame(10'000 * i, data_frame(0x0CF00400, {1, 2, 3, 4, 5, 6, 7, 8}, true));
    heard.frame(10'000 * i + 900, data_frame(0x18FEF100, {1, 2, 3, 4, 5, 6, 7, 8}, true));
  }
  EXPECT_EQ(heard.kind(), LineKind::j1939);
  heard.frame(2'000'000, data_frame(0x18EEFF00, {1, 2, 3, 4, 5, 6, 7, 8}, true));
  EXPECT_EQ(heard.census().evidence.claims, 1U);
}

TEST(Evidence, TwentyNineBitIdentifiersOfNoParameterGroupAreUnknown) {
  Heard heard;
  for (int i = 0; i < 200; ++i)
    heard.frame(10'000 * i, data_frame(0x10004000U + static_cast<unsigned>(i % 7), {1}, true));
  EXPECT_EQ(heard.kind(), LineKind::unknown);
}

TEST(Evidence, AMasterWhoseDrivesAreOffInSetUpIsCansync) {
  Heard heard;
  for (int i = 0; i < 100; ++i)
    heard.frame(8000 * (i + i / 3 * 4),
                data_frame(0x500U + static_cast<unsigned>(i % 3), {0x2D, 0x71, 0, 0}));
  EXPECT_EQ(heard.kind(), LineKind::cansync) << heard.census().evidence.confidence();
}

/// Heartbeats are off, and nobody asks by SDO.
TEST(Evidence, ProcessDataOfCanopenAloneIsUnknown) {
  Heard heard;
  for (int i = 0; i < 1000; ++i) {
    heard.frame(1000 * i, data_frame(0x080, {}));
    heard.frame(1000 * i + 150, data_frame(0x181, {1, 2, 3, 4, 5, 6, 7, 8}));
    heard.frame(1000 * i + 300, data_frame(0x381, {1, 2, 3, 4, 5, 6, 7, 8}));
    heard.frame(1000 * i + 450, data_frame(0x501, {1, 2, 3, 4, 5, 6, 7, 8}));
  }
  EXPECT_EQ(heard.kind(), LineKind::unknown) << heard.census().evidence.confidence();
}

/// SYNC, process data that has identifiers of CANsync, heartbeats, and SDO transfers.
TEST(Evidence, CanopenWithSyncIsCanopen) {
  Heard heard;
  for (int i = 0; i < 1000; ++i) {
    const int us = 1000 * i;
    heard.frame(us, data_frame(0x080, {}));
    heard.frame(us + 150, data_frame(0x181, {1, 2, 3, 4, 5, 6, 7, 8}));
    heard.frame(us + 300, data_frame(0x381, {1, 2, 3, 4, 5, 6, 7, 8}));
    heard.frame(us + 450, data_frame(0x501, {1, 2, 3, 4, 5, 6, 7, 8}));
    if (i % 100 == 0) heard.frame(us + 700, data_frame(0x701, {5}));
    if (i % 100 == 50) {
      heard.frame(us + 600, data_frame(0x601, {0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));
      heard.frame(us + 800, data_frame(0x581, {0x4B, 0x41, 0x60, 0, 0x37, 0x12, 0, 0}));
    }
  }
  EXPECT_EQ(heard.kind(), LineKind::canopen);
  EXPECT_EQ(heard.census().evidence.sdo_pairs, 10U);
}

TEST(Evidence, ACarIsUnknown) {
  std::mt19937 random(1);
  Heard heard;
  // Identifiers of the three ranges of CANsync, each with its own period.
  const std::vector<std::pair<std::uint32_t, int>> sent = {
      {0x120, 10'000},  {0x136, 10'000},  {0x13A, 10'000},   {0x13F, 20'000}, {0x164, 10'000},
      {0x166, 10'000},  {0x18E, 10'000},  {0x191, 10'000},   {0x1A4, 20'000}, {0x305, 100'000},
      {0x309, 100'000}, {0x320, 40'000},  {0x333, 40'000},   {0x37C, 40'000}, {0x405, 100'000},
      {0x40C, 300'000}, {0x506, 100'000}, {0x5A1, 1'000'000}};
  for (int us = 0; us < 2'000'000; us += 250)
    for (std::size_t i = 0; i < sent.size(); ++i)
      if ((us + 250 * static_cast<int>(i)) % sent[i].second == 0) {
        can::Frame frame = data_frame(sent[i].first, {1, 2, 3, 4, 5, 6, 7, 8});
        frame.data[3] = static_cast<std::uint8_t>(random());
        heard.frame(us, frame);
      }
  EXPECT_EQ(heard.kind(), LineKind::unknown) << heard.census().evidence.confidence();
}

/// A bus of 1 Mbit/s, whose adapter hands over what came every 2 or 4 ms: the stamps say the interval of a slower one.
TEST(Evidence, BunchedStampsTellNoIntervalAndNoSecondMaster) {
  for (const int together : {2, 4}) {
    Heard heard;
    for (int i = 0; i < 1000; ++i) {
      const int us = 1000 * together * (i / together);
      heard.frame(us, data_frame(0x080, {}));
      heard.frame(us, data_frame(0x101, {1, 0, 2, 0, 3, 0, 4, 0}));
      heard.frame(us, data_frame(0x301, {1, 0, 2, 0, 3, 0, 4, 0}));
    }
    const Census census = heard.census();
    EXPECT_TRUE(census.stamps.bunched());
    EXPECT_EQ(census.interval.votes, 0U);
    EXPECT_FALSE(census.second_master());
    EXPECT_EQ(census.evidence.kind(), LineKind::cansync) << "their order says so";
  }
}

/// A virtual interface has no bit times, but the interval is that of its master.
TEST(Evidence, AnIntervalThatBunchedStampsRepeatIsKnown) {
  Heard heard;
  for (int i = 0; i < 1000; ++i) {
    const int us = 8000 * i + i % 5 * 150;
    heard.frame(us, data_frame(0x080, {}));
    heard.frame(us + 3000, data_frame(0x101, {1, 0, 2, 0, 3, 0, 4, 0}));
    heard.frame(us + 3010, data_frame(0x301, {1, 0, 2, 0, 3, 0, 4, 0}));
  }
  const Census census = heard.census();
  EXPECT_TRUE(census.stamps.bunched());
  EXPECT_EQ(census.interval.bit_rate, BitRate::kbit125);
  EXPECT_FALSE(census.second_master());
}

TEST(Evidence, StampsOfFewDigitsTellNoPlaceInTheInterval) {
  Observer observer({Stamps::end, BitRate::kbit125});
  for (int i = 0; i < 100; ++i) {
    const Duration at = std::chrono::milliseconds(8 * i);
    const can::Frame edge = data_frame(0x080, {});
    observer.sync(at, &edge);
    observer.frame(at + std::chrono::milliseconds(3), data_frame(0x101, {1, 0}));
  }
  const Observation observation = observer.finish();
  EXPECT_FALSE(observation.stamps.bunched());
  EXPECT_TRUE(observation.stamps.coarse());
  EXPECT_EQ(observation.bit_rate, BitRate::kbit125);
  EXPECT_GT(observation.interval_votes, 0U);
  for (const SlotUse& slot : observation.slot) EXPECT_EQ(slot.count, 0U);
}

TEST(Evidence, BunchedStampsOfARecordingTellNoTiming) {
  Observer observer({Stamps::end, BitRate::mbit1});
  for (int i = 0; i < 1000; ++i) {
    const Duration at = std::chrono::milliseconds(4 * (i / 4));
    const can::Frame edge = data_frame(0x080, {});
    observer.sync(at, &edge);
    observer.frame(at, data_frame(0x100u + static_cast<unsigned>(i % 3), {1, 0, 2, 0, 3, 0, 4, 0}));
    observer.frame(at, data_frame(0x300u + static_cast<unsigned>(i % 3), {1, 0, 2, 0, 3, 0, 4, 0}));
  }
  const Observation observation = observer.finish();
  EXPECT_TRUE(observation.stamps.bunched());
  EXPECT_EQ(observation.interval_votes, 0U);
  for (const SlotUse& slot : observation.slot) EXPECT_EQ(slot.count, 0U);
  EXPECT_EQ(observation.intervals, 1000U) << "each edge begins one";
  EXPECT_EQ(observation.polling[0].wraps, 333U);
  EXPECT_EQ(observation.references_missing, 0U);
}

}  // namespace
}  // namespace cansync::observe
