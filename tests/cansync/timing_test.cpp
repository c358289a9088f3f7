// The slot table of M 3.1.1 against figures typed a second time, and what they must satisfy together.

#include "cansync/settings/timing.h"

#include <gtest/gtest.h>

namespace cansync {
namespace {

using std::chrono::microseconds;

// Bit rate in kbit/s; tSYNC, tRC, tWRC1, tRDC1, tWRC2, tRDC2, tCC, tRSPTO in us; length in m.
struct Row {
  std::uint32_t kbit;
  std::array<int, 9> figures;
};
constexpr std::array<Row, 4> kManual = {{
    {1000, {1000, 210, 350, 520, 650, 820, 950, 300, 34}},
    {500, {2000, 460, 730, 1060, 1320, 1630, 1890, 600, 134}},
    {250, {4000, 900, 1430, 2100, 2620, 3290, 3810, 1100, 300}},
    {125, {8000, 1920, 3020, 4310, 5350, 6640, 7680, 2100, 600}},
}};

TEST(SlotTimes, AreTheManuals) {
  for (const Row& row : kManual) {
    const auto times = slot_times_for(row.kbit * 1000);
    ASSERT_TRUE(times) << row.kbit;
    const std::array<Duration, 8> found = {times->interval,   times->response,        times->reference_one,
                                           times->actual_one, times->reference_two,   times->actual_two,
                                           times->command,    times->response_timeout};
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i], microseconds(row.figures[i])) << row.kbit << " kbit/s, column " << i;
    }
    EXPECT_EQ(times->bus_length_m, row.figures[8]);
    EXPECT_EQ(slot_times(times->bit_rate).bits_per_second, row.kbit * 1000);
    EXPECT_EQ(times->bit_time(), Duration(1'000'000 / row.kbit));
  }
}

TEST(SlotTimes, NoOtherBitRate) {
  for (const std::uint32_t rate : {0u, 1u, 3u, 6u, 100'000u, 124'999u, 800'000u, 1'000'001u}) {
    EXPECT_FALSE(slot_times_for(rate)) << rate;
  }
}

TEST(SlotTimes, RiseWithinTheInterval) {
  for (const SlotTimes& times : kSlotTimes) {
    EXPECT_LT(Duration{0}, times.response);
    EXPECT_LT(times.response, times.reference_one);
    EXPECT_LT(times.reference_one, times.actual_one);
    EXPECT_LT(times.actual_one, times.reference_two);
    EXPECT_LT(times.reference_two, times.actual_two);
    EXPECT_LT(times.actual_two, times.command);
    EXPECT_LT(times.command, times.interval);
  }
}

// Read as latest starts, each slot holds a frame of 8 bytes without stuff bits (111 bits) before the next
// one.
TEST(SlotTimes, ReadAsStartsEachSlotHoldsAFrame) {
  for (const SlotTimes& times : kSlotTimes) {
    const Duration frame = 111 * times.bit_time();
    EXPECT_LE(times.response + frame, times.reference_one);
    EXPECT_LE(times.reference_one + frame, times.actual_one);
    EXPECT_LE(times.actual_one + frame, times.reference_two);
    EXPECT_LE(times.reference_two + frame, times.actual_two);
    EXPECT_LE(times.actual_two + frame, times.command);
    // A command started last ends in the next interval and leaves its answer time until tRC.
    EXPECT_LE(times.command + frame, times.interval + times.response);
  }
}

}  // namespace
}  // namespace cansync
