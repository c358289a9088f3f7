#include "layer2/data_mapping.h"

#include <gtest/gtest.h>

#include <chrono>
#include <vector>

#include "can/flagged_frames.h"

namespace layer2 {
namespace {

using can::test::data_frame;
using can::test::extended;
using can::test::remote;
using std::chrono::milliseconds;

MappedBytes in(std::uint32_t id, std::uint8_t offset, std::uint16_t address, std::uint8_t size) {
  return {id, offset, address, size, false};
}
MappedBytes out(std::uint32_t id, std::uint8_t offset, std::uint16_t address, std::uint8_t size) {
  return {id, offset, address, size, true};
}

DataMapping mapping(const std::vector<MappedBytes>& table, const MappingSettings& settings = {}) {
  EXPECT_EQ(DataMapping::check(settings, table).problem, MappingProblem::none);
  DataMapping mapping;
  mapping.configure(settings, table);
  mapping.start(Time{0});
  mapping.set_sending(true);
  return mapping;
}

/// The frames that go out at an instant.
std::vector<can::Frame> sent(DataMapping& mapping, Time now) {
  std::vector<can::Frame> frames;
  mapping.advance(now);
  while (const auto telegram = mapping.next()) {
    frames.push_back(mapping.frame(*telegram));
    mapping.handed_over(*telegram, frames.back());
  }
  return frames;
}

TEST(DataMapping, L55BytesComeWhereTheyAreMappedWhateverTheLength) {
  // The example of the manual.
  DataMapping image = mapping({in(0x318, 0, 10, 2), in(0x318, 2, 512, 2), in(0x318, 4, 35, 1)});
  EXPECT_TRUE(image.receive(data_frame(0x318, {1, 2, 3, 4, 5, 6, 7, 8})));  // longer: the rest is ignored
  EXPECT_EQ(image.inputs()[10], 1);
  EXPECT_EQ(image.inputs()[11], 2);
  EXPECT_EQ(image.inputs()[512], 3);
  EXPECT_EQ(image.inputs()[513], 4);
  EXPECT_EQ(image.inputs()[35], 5);
  EXPECT_TRUE(image.receive(data_frame(0x318, {9, 8, 7})));  // shorter: the rest keeps its value
  EXPECT_EQ(image.inputs()[10], 9);
  EXPECT_EQ(image.inputs()[512], 7);
  EXPECT_EQ(image.inputs()[513], 4);
  EXPECT_EQ(image.inputs()[35], 5);
  EXPECT_EQ(image.received(), 2u);
}

TEST(DataMapping, L58WhatHasNoEntryIsDropped) {
  DataMapping image = mapping({in(0x318, 0, 10, 2)}, {.rule = {.identifier = 0x300, .mask = 0x700}});
  EXPECT_TRUE(image.receive(data_frame(0x319, {1})));
  EXPECT_EQ(image.dropped(), 1u);
  EXPECT_FALSE(image.receive(data_frame(0x418, {1})));  // it is not the mapping's
  EXPECT_FALSE(image.receive(extended(data_frame(0x318, {1}))));
  EXPECT_FALSE(image.receive(remote(data_frame(0x318, {}))));
}

TEST(DataMapping, L54ATelegramIsAsLongAsItsHighestMappedByte) {
  DataMapping image = mapping({out(0x201, 2, 0, 2), out(0x202, 7, 5, 1), out(0x203, 0, 6, 1)});
  image.outputs()[0] = 0xAA;
  image.outputs()[1] = 0xBB;
  image.outputs()[5] = 0xCC;
  const std::vector<can::Frame> wanted = {data_frame(0x201, {0, 0, 0xAA, 0xBB}),
                                          data_frame(0x202, {0, 0, 0, 0, 0, 0, 0, 0xCC}),
                                          data_frame(0x203, {0})};
  EXPECT_EQ(sent(image, Time{0}), wanted);
}

TEST(DataMapping, L52AllTelegramsGoEveryInterval) {
  MappingSettings settings;
  settings.interval = milliseconds(20);
  DataMapping image = mapping({out(1, 0, 0, 1), out(2, 0, 1, 1)}, settings);
  EXPECT_EQ(sent(image, Time{0}).size(), 2u);
  EXPECT_EQ(image.next_deadline(), milliseconds(20));
  EXPECT_TRUE(sent(image, milliseconds(20) - Time{1}).empty());
  EXPECT_EQ(sent(image, milliseconds(21)).size(), 2u);
  EXPECT_EQ(image.next_deadline(), milliseconds(40));   // late once, not later each time
  EXPECT_EQ(sent(image, milliseconds(95)).size(), 2u);  // what went by is not made up for
  EXPECT_EQ(image.next_deadline(), milliseconds(100));
  EXPECT_EQ(image.sent(), 6u);
}

TEST(DataMapping, L53OnlyWhatHasChangedGoes) {
  MappingSettings settings;
  settings.on_change = true;
  DataMapping image = mapping({out(1, 0, 0, 1), out(2, 0, 1, 1)}, settings);
  EXPECT_EQ(sent(image, Time{0}).size(), 2u);  // each once
  EXPECT_TRUE(sent(image, milliseconds(10)).empty());
  image.outputs()[1] = 7;
  EXPECT_EQ(sent(image, milliseconds(20)), std::vector<can::Frame>{data_frame(2, {7})});
  image.outputs()[1] = 8;
  image.outputs()[1] = 7;  // back before anybody looked
  EXPECT_TRUE(sent(image, milliseconds(30)).empty());
  settings.first_always = false;
  DataMapping quiet = mapping({out(1, 0, 0, 1)}, settings);
  EXPECT_TRUE(sent(quiet, Time{0}).empty());
  quiet.outputs()[0] = 1;
  EXPECT_EQ(sent(quiet, milliseconds(10)).size(), 1u);
}

TEST(DataMapping, WhatAnEmptiedControllerMayHaveLostGoesOnceMore) {
  MappingSettings settings;
  settings.on_change = true;
  DataMapping image = mapping({out(1, 0, 0, 1)}, settings);
  image.outputs()[0] = 7;
  EXPECT_EQ(sent(image, Time{0}), std::vector<can::Frame>{data_frame(1, {7})});
  image.controller_emptied();
  EXPECT_EQ(sent(image, milliseconds(10)), std::vector<can::Frame>{data_frame(1, {7})});
  EXPECT_TRUE(sent(image, milliseconds(20)).empty());
}

TEST(DataMapping, L56WithoutSendingTelegramsAreTakenAndNoneIsSent) {
  DataMapping image;
  const MappedBytes table[] = {{.identifier = 0x181, .address = 3},
                               {.identifier = 0x201, .address = 0, .output = true}};
  image.configure({.interval = milliseconds(10)}, table);
  image.start(Time{0});
  image.advance(Time{0});
  EXPECT_FALSE(image.next()) << "nobody has written yet";
  image.set_sending(true);
  image.advance(milliseconds(10));
  ASSERT_TRUE(image.next());
  image.set_sending(false);
  EXPECT_FALSE(image.next()) << "also what was due";
  image.advance(milliseconds(20));
  EXPECT_FALSE(image.next());
  EXPECT_TRUE(image.receive(data_frame(0x181, {5})));
  EXPECT_EQ(image.inputs()[3], 5);
  image.set_sending(true);
  EXPECT_FALSE(image.next()) << "not before the next interval";
  image.advance(milliseconds(30));
  EXPECT_TRUE(image.next());
}

TEST(DataMapping, AnotherTableBeginsWithNothingOfTheOneBefore) {
  DataMapping image = mapping({out(1, 0, 0, 1), in(2, 0, 5, 1)});
  image.outputs()[0] = 7;
  EXPECT_TRUE(image.receive(data_frame(2, {9})));
  DataMapping next = mapping({out(3, 0, 0, 1)});
  image.swap_table(next);
  EXPECT_EQ(image.table(), 1u);
  image.start(Time{0});
  EXPECT_TRUE(sent(image, Time{0}).empty()) << "nobody has written yet";
  EXPECT_EQ(image.inputs()[5], 0);
  image.set_sending(true);
  EXPECT_EQ(sent(image, milliseconds(10)), std::vector<can::Frame>{data_frame(3, {0})});
}

TEST(DataMapping, AChangeOfTheStandstillGoesWhenItRuns) {
  DataMapping image = mapping({out(1, 0, 0, 1)}, {.on_change = true, .first_always = false});
  image.outputs()[0] = 1;
  EXPECT_EQ(sent(image, Time{0}).size(), 1u);
  image.stop();
  image.outputs()[0] = 2;
  image.start(milliseconds(50));
  EXPECT_EQ(sent(image, milliseconds(50)), std::vector<can::Frame>{data_frame(1, {2})});
  image.stop();
  image.start(milliseconds(70));
  EXPECT_TRUE(sent(image, milliseconds(70)).empty());
}

// 20 of 60 telegrams have room in an interval.
TEST(DataMapping, WhatTheBusHasNoRoomForTakesTurnsAndIsCounted) {
  std::vector<MappedBytes> table;
  for (std::uint32_t i = 0; i < 60; ++i) table.push_back(out(i, 0, static_cast<std::uint16_t>(8 * i), 8));
  DataMapping image = mapping(table);
  std::vector<std::uint32_t> order;
  for (int interval = 0; interval < 30; ++interval) {
    image.advance(milliseconds(10 * interval));
    for (int i = 0; i < 20; ++i) {
      const auto telegram = image.next();
      ASSERT_TRUE(telegram);
      order.push_back(image.frame(*telegram).id);
      image.handed_over(*telegram, image.frame(*telegram));
    }
  }
  for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], i % 60) << "each as often as the others";
  EXPECT_EQ(image.left_out(), 29u * 40u);
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < image.telegrams(); ++i) sum += image.left_out(i).times;
  EXPECT_EQ(sum, image.left_out());
  EXPECT_EQ(image.left_out(59).identifier, 59u);
  EXPECT_GT(image.left_out(59).times, 15u);
}

TEST(DataMapping, ATableWithoutInputsTakesNothingAndOneWithoutAMaskItsIdentifiersAlone) {
  DataMapping outputs = mapping({out(1, 0, 0, 1)});
  EXPECT_FALSE(outputs.receive(data_frame(1, {1})));
  EXPECT_FALSE(outputs.receive(data_frame(2, {1})));
  EXPECT_EQ(outputs.dropped(), 0u);
  DataMapping alone = mapping({in(2, 0, 0, 1)}, {.table_alone = true});
  EXPECT_TRUE(alone.receive(data_frame(2, {1})));
  EXPECT_FALSE(alone.receive(data_frame(3, {1})));
  EXPECT_FALSE(alone.receive(extended(data_frame(2, {1}))));
  EXPECT_EQ(alone.dropped(), 0u);
}

TEST(DataMapping, L57ItStopsAndNeedsToBeStartedAnew) {
  DataMapping image = mapping({out(1, 0, 0, 1), in(2, 0, 0, 1)});
  image.advance(Time{0});
  image.stop();
  EXPECT_FALSE(image.next());
  EXPECT_FALSE(image.receive(data_frame(2, {1})));
  EXPECT_EQ(image.next_deadline(), Time::max());
  image.configure({}, {});  // no entries
  image.start(Time{0});
  EXPECT_FALSE(image.runs());
}

TEST(DataMapping, L50ATableIsChecked) {
  const MappingSettings high{.rule = {.identifier = 0, .mask = 0x600}};
  const struct {
    MappedBytes entry;
    MappingProblem problem;
  } wrong[] = {{in(0x800, 0, 0, 1), MappingProblem::identifier},
               {in(0x300, 0, 0, 1), MappingProblem::not_in_rule},
               {in(0x100, 0, 0, 0), MappingProblem::bytes},
               {in(0x100, 7, 0, 2), MappingProblem::bytes},
               {out(0x100, 0, 1023, 2), MappingProblem::address},
               {in(0x101, 0, 9, 2), MappingProblem::address_taken},
               {out(0x102, 3, 99, 1), MappingProblem::bytes_taken},
               {in(0x103, 0, 99, 1), MappingProblem::bytes_taken}};
  for (const auto& one : wrong) {
    const std::vector<MappedBytes> table = {in(0x103, 0, 10, 2), out(0x102, 2, 10, 2), one.entry};
    const auto fault = DataMapping::check(high, table);
    EXPECT_EQ(fault.problem, one.problem);
    EXPECT_EQ(fault.entry, 2u);
  }
  EXPECT_EQ(DataMapping::check(high, std::vector{out(0x700, 0, 0, 8)}).problem, MappingProblem::none);
  EXPECT_EQ(DataMapping::check({.interval = Time{0}}, {}).problem, MappingProblem::interval);
}

TEST(DataMapping, L51HowMuchThereIsRoomFor) {
  std::vector<MappedBytes> table;
  for (std::uint32_t i = 0; i < 128; ++i) {
    const auto address = static_cast<std::uint16_t>(8 * i);
    table.push_back(in(i, 0, address, 8));
    table.push_back(out(i, 0, address, 8));
  }
  DataMapping image = mapping(table);  // 2048 bytes in 256 telegrams; one of each direction for an identifier
  EXPECT_TRUE(image.receive(data_frame(127, {1, 2, 3, 4, 5, 6, 7, 8})));
  EXPECT_EQ(image.inputs()[1023], 8);
  EXPECT_EQ(sent(image, Time{0}).size(), 128u);
  table.push_back(out(0x200, 0, 0, 1));
  const auto fault = DataMapping::check({}, table);
  EXPECT_EQ(fault.problem, MappingProblem::messages);
  EXPECT_EQ(fault.entry, 256u);
}

}  // namespace
}  // namespace layer2
