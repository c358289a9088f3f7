#include "daemon/cansync/slot_statistics.h"

#include <gtest/gtest.h>

#include <chrono>

#include "can/frame_length.h"
#include "support/loop_rig.h"

namespace cansyncd {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr can::Time kSync = std::chrono::seconds(5);

can::Frame frame(std::uint32_t id, std::uint8_t dlc = 8) {
  can::Frame out;
  out.id = id;
  out.dlc = dlc;
  return out;
}

/// Statistics of a line at 1 Mbit/s that are told of starts instead of ends.
struct Statistics {
  SlotStatistics statistics{cansync::slot_times(cansync::BitRate::mbit1)};
  void start(const can::Frame& started, can::Time after, can::Time sync = kSync) {
    const unsigned bits = can::frame_bits(started);
    statistics.add(started, bits, sync + after + microseconds(bits - can::kInterframeBits), sync);
  }
  static SlotSummary of(const SlotSummaries& taken, TelegramClass slot) {
    return taken[static_cast<unsigned>(slot)];
  }
};

TEST(SlotStatistics, EveryChannelHasItsClass) {
  EXPECT_EQ(telegram_class(frame(0x010)), TelegramClass::command);
  EXPECT_EQ(telegram_class(frame(0x100 + 127)), TelegramClass::reference_one);
  EXPECT_EQ(telegram_class(frame(0x180)), TelegramClass::reference_two);
  EXPECT_EQ(telegram_class(frame(0x31F)), TelegramClass::actual_one);
  EXPECT_EQ(telegram_class(frame(0x380)), TelegramClass::actual_two);
  EXPECT_EQ(telegram_class(frame(0x500)), TelegramClass::command);
  EXPECT_EQ(telegram_class(frame(0x59F)), TelegramClass::response);
  EXPECT_EQ(telegram_class(frame(0x011)), std::nullopt);
  EXPECT_EQ(telegram_class(frame(0x700)), std::nullopt);
  can::Frame extended = frame(0x100);
  extended.extended = true;
  EXPECT_EQ(telegram_class(extended), std::nullopt);
}

TEST(SlotStatistics, TellsEarliestMeanAndLatestStartOfWhatWasSeen) {
  Statistics rig;
  for (const int us : {300, 330, 303}) rig.start(frame(0x101), microseconds(us));
  rig.start(frame(0x301), microseconds(430));
  const SlotSummaries taken = rig.statistics.take();
  const SlotSummary one = rig.of(taken, TelegramClass::reference_one);
  EXPECT_EQ(one.count, 3u);
  EXPECT_EQ(one.earliest, microseconds(300));
  EXPECT_EQ(one.mean, microseconds(311));
  EXPECT_EQ(one.latest, microseconds(330));
  EXPECT_EQ(one.late, 0u);
  EXPECT_EQ(rig.of(taken, TelegramClass::actual_one).count, 1u);
  EXPECT_EQ(rig.of(taken, TelegramClass::actual_two).count, 0u);
}

TEST(SlotStatistics, LateIsAfterTheLatestStartAndCountedSinceTheStart) {
  Statistics rig;
  rig.start(frame(0x101), microseconds(350));
  EXPECT_EQ(rig.of(rig.statistics.take(), TelegramClass::reference_one).late, 0u)
      << "exactly at it is in time";
  rig.start(frame(0x101), microseconds(350) + can::Time(1));
  EXPECT_EQ(rig.of(rig.statistics.take(), TelegramClass::reference_one).late, 1u);
  const SlotSummary nothing_new = rig.of(rig.statistics.take(), TelegramClass::reference_one);
  EXPECT_EQ(nothing_new.count, 0u);
  EXPECT_EQ(nothing_new.late, 1u);
  EXPECT_EQ(nothing_new.latest, microseconds(0));
}

TEST(SlotStatistics, ACommandThatBeganBeforeTheEdgeBelongsToTheIntervalBefore) {
  Statistics rig;
  rig.start(frame(0x501, 4), microseconds(-50));  // ends after the edge
  const SlotSummary command = rig.of(rig.statistics.take(), TelegramClass::command);
  EXPECT_EQ(command.earliest, microseconds(950));
  EXPECT_EQ(command.late, 0u);
}

TEST(SlotStatistics, AnAnswerBeforeTheEdgeIsEarlyAndOneBeforeTheCommandIsLate) {
  Statistics rig;
  rig.start(frame(0x501, 4), microseconds(870));
  rig.start(frame(0x581, 2), microseconds(960));  // the answer to this very command, before the next edge
  const SlotSummary early = rig.of(rig.statistics.take(), TelegramClass::response);
  EXPECT_EQ(early.earliest, microseconds(-40));
  EXPECT_EQ(early.late, 0u);
  rig.start(frame(0x581, 2), microseconds(215),
            kSync + milliseconds(1));  // to the command of the interval before
  const SlotSummary late = rig.of(rig.statistics.take(), TelegramClass::response);
  EXPECT_EQ(late.earliest, microseconds(215));
  EXPECT_EQ(late.late, 1u);
}

TEST(SlotStatistics, TheLoopTellsOfTelegramsInActiveOperation) {
  test::LoopRig rig;
  cansync::ReferenceUpdate update;
  update.channel = cansync::Channel::one;
  update.valid_mask = 1;
  update.release_intervals = 1000;
  rig.push_at(60, update);
  rig.run_until(1002);
  TimingSnapshot timing;
  ASSERT_TRUE(rig.exchange.timing.read(timing));
  const SlotSummary one = Statistics::of(timing.slots, TelegramClass::reference_one);
  EXPECT_GT(one.count, 900u);
  // The scripted bus counts the interframe space to the frame.
  EXPECT_EQ(one.earliest, timing.planned[0] + microseconds(3));
  EXPECT_EQ(one.latest, one.earliest);
  EXPECT_EQ(one.late, 0u);
  EXPECT_GT(Statistics::of(timing.slots, TelegramClass::actual_one).count, 900u);
  EXPECT_EQ(Statistics::of(timing.slots, TelegramClass::reference_two).count, 0u)
      << "no values were given for it";
}

}  // namespace
}  // namespace cansyncd
