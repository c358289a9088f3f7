// Who speaks on a line: the counts of random lines are those of a plain look at their identifiers.
#include "cansync/observe/census.h"

#include <gtest/gtest.h>

#include <map>

#include "cansync/observe/random_line.h"

namespace cansync::observe {
namespace {

using support::Recording;

Census census_of(const Recording& recording) {
  CensusTaker taker;
  for (const Recording::Entry& entry : recording.entries)
    entry.frame ? taker.frame(entry.start, *entry.frame) : taker.sync(entry.start, nullptr);
  return taker.census();
}

TEST(Census, CountsWhatStandsOnRandomLines) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const auto line = support::random_line(seed, false);
    const Recording recording = support::record(line, line.master);
    std::map<std::uint32_t, std::uint64_t> frames;
    std::uint64_t edges = 0;
    for (const Recording::Entry& entry : recording.entries) entry.frame ? ++frames[entry.frame->id] : ++edges;
    const Census census = census_of(recording);
    EXPECT_EQ(census.edges, edges);
    EXPECT_EQ(census.actions.count, frames[0x010]);
    EXPECT_EQ(census.interval.bit_rate, line.master.master.bit_rate);
    EXPECT_TRUE(census.master());
    EXPECT_FALSE(census.second_master());
    for (std::uint32_t n = 0; n < kSlaves; ++n) {
      EXPECT_EQ(census.slave[n].actual[0].count, frames[0x300 + n]) << n;
      EXPECT_EQ(census.slave[n].actual[1].count, frames[0x380 + n]) << n;
      EXPECT_EQ(census.slave[n].answers.count, frames[0x580 + n]) << n;
      EXPECT_EQ(census.slave[n].polled[0], frames[0x100 + n]) << n;
    }
  }
}

TEST(Census, TellsTwoMasters) {
  CensusTaker taker;
  can::Frame reference;
  reference.id = 0x17F;
  reference.dlc = 8;
  for (int i = 0; i < 1000; ++i) {
    taker.frame(std::chrono::microseconds(2000 * i), reference);
    taker.frame(std::chrono::microseconds(2000 * i + 300), reference);
    can::Frame second = reference;
    second.id = 0x1FF;
    taker.frame(std::chrono::microseconds(2000 * i + 900), second);
  }
  EXPECT_TRUE(taker.census().second_master());
}

TEST(Census, KeepsABoundedListOfForeignIdentifiers) {
  CensusTaker taker;
  for (unsigned i = 0; i < 1000; ++i) {
    can::Frame frame;
    frame.extended = true;
    frame.id = 0x18FF0000u + i;
    frame.dlc = static_cast<std::uint8_t>(i % 9);
    taker.frame(std::chrono::microseconds(100 * i), frame);
  }
  const Census census = taker.census();
  EXPECT_EQ(census.foreign.size(), kMostForeign);
  EXPECT_EQ(census.foreign_over, 1000 - kMostForeign);
  EXPECT_EQ(census.foreign[5].lengths, 1u << 5);
  EXPECT_FALSE(census.master());
}

}  // namespace
}  // namespace cansync::observe
