#include "cli/record/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "cli/text/values.h"
#include "cli/watch/live_rig.h"

namespace cansync::cli {
namespace {

/// Two slaves: 0 "unwinder" with position [mm] and torque [%], 3 without a name, whose values have none
/// either.
class Recording : public testing::Test {
 protected:
  Recording() {
    LiveRig rig{{"unwinder", "x"}};
    slaves = {rig.rows[0].status, rig.rows[1].status};
    slaves[0].actual_mapping[2] = 0x11;  // value 4, which telegram 2 carries
    slaves[0].actual_mapping[3] = 0x13;
    put(slaves[0].actual_value[4].name, "torque");
    put(slaves[0].actual_value[4].unit_symbol, "%");
    slaves[1].slave = 3;
    put(slaves[1].name, "");
    slaves[1].actual_value[0] = {};
    for (std::size_t i = 2; i < 4; ++i) slaves[1].actual_mapping[i] = 0;
    status.polling_one = client::kAutomatic;
    status.polling_two = client::kNobody;
    status.maximum_slave = 3;
  }

  /// What comes of a slave in an interval; `telegrams`: bit 0 and 1.
  client::ActualValues sample(unsigned slave, std::uint64_t interval, unsigned telegrams) {
    client::ActualValues& values = newest[slave];
    values.slave = static_cast<std::uint8_t>(slave);
    values.arrived = static_cast<std::uint8_t>(telegrams);
    values.ever = static_cast<std::uint8_t>(values.ever | telegrams);
    values.receive_time = kNoon + static_cast<std::int64_t>(interval) * 1'000'000;
    for (unsigned telegram = 0; telegram < 2; ++telegram) {
      if (((telegrams >> telegram) & 1u) == 0) continue;
      values.interval[telegram] = interval;
      values.raw[4 * telegram] = static_cast<std::uint32_t>(-static_cast<std::int32_t>(interval));
      values.scaled[4 * telegram] = -static_cast<double>(interval) / 10;
    }
    return values;
  }

  std::vector<client::SlaveStatus> slaves;
  client::MasterStatus status = {};
  std::map<unsigned, client::ActualValues> newest;
};

TEST_F(Recording, HasAColumnForEachNameAndUnit) {
  EXPECT_EQ(RecordPlan(slaves, {}, false).header(),
            "time,seconds,receive_time_ns,interval,slave,name,position [mm],value0,torque [%]\n");
  EXPECT_EQ(RecordPlan(slaves, {"torque"}, true).header(),
            "time,seconds,receive_time_ns,interval,slave,name,torque [raw]\n");
  EXPECT_EQ(RecordPlan(slaves, {"0"}, false).headings(),
            (std::vector<std::string>{"position [mm]", "value0"}));
}

TEST_F(Recording, RefusesAValueThatNobodyHas) {
  try {
    const RecordPlan plan(slaves, {"torque", "speed"}, false);
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "--values: found 'speed'; allowed, of these slaves: position, torque, value0");
  }
}

TEST_F(Recording, ARowHoldsWhatCameInOneInterval) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 3));
  rows.take(sample(3, 7, 1));
  rows.take(sample(0, 8, 1));
  rows.take(sample(0, 8, 2));
  rows.take(sample(3, 11, 1));
  rows.take(sample(0, 12, 2));
  EXPECT_EQ(rows.lines(true),
            "1970-01-01T12:00:00.008000000Z,0.000000,43200008000000,8,0,unwinder,-0.8,,-0.8\n"
            "1970-01-01T12:00:00.011000000Z,0.003000,43200011000000,11,3,,,-1.1,\n"
            "1970-01-01T12:00:00.012000000Z,0.004000,43200012000000,12,0,unwinder,,,-1.2\n");
  EXPECT_EQ(rows.counts().rows, 3u);
}

TEST_F(Recording, ARawWordHasItsOwnSign) {
  RecordPlan plan(slaves, {"position", "torque"}, true);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 3));
  newest[0].words = 0x10;
  client::ActualValues word = sample(0, 8, 3);
  word.raw[4] = 0xFF9C;
  rows.take(word);
  EXPECT_EQ(rows.lines(true),
            "1970-01-01T12:00:00.008000000Z,0.000000,43200008000000,8,0,unwinder,-8,-100\n");
}

TEST_F(Recording, ATelegramWhoseOwnSampleWasOvertakenIsNotLost) {
  RecordPlan plan(slaves, {"position", "torque"}, true);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 3));
  static_cast<void>(sample(0, 8, 1));  // only the newest sample of a slave is kept on the way
  rows.take(sample(0, 8, 2));
  EXPECT_EQ(rows.lines(true), "1970-01-01T12:00:00.008000000Z,0.000000,43200008000000,8,0,unwinder,-8,-8\n");
}

TEST_F(Recording, RowsAreHeldBackUntilTheIntervalIsOver) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 1));
  rows.take(sample(0, 8, 1));
  EXPECT_EQ(rows.lines(false), "");
  rows.take(sample(0, 12, 1));
  EXPECT_EQ(rows.lines(false), "") << "more of what waits may come";
  EXPECT_NE(rows.lines(false).find(",8,0,unwinder,"), std::string::npos);
  EXPECT_NE(rows.lines(true).find(",12,0,unwinder,"), std::string::npos);
}

// What waits in DDS is given slave by slave; half of it may be here when rows are written.
TEST_F(Recording, RowsStandInTheOrderOfIntervalsAlsoWhenASlaveComesLate) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 1));
  rows.take(sample(3, 7, 1));
  for (const std::uint64_t interval : {12u, 16u, 20u}) rows.take(sample(0, interval, 1));
  std::string all = rows.lines(false);
  rows.take(sample(3, 15, 1));
  all += rows.lines(false) + rows.lines(true);
  ASSERT_EQ(std::count(all.begin(), all.end(), '\n'), 4) << all;
  EXPECT_LT(all.find(",12,0,"), all.find(",15,3,")) << all;
  EXPECT_LT(all.find(",15,3,"), all.find(",16,0,")) << all;
  EXPECT_LT(all.find(",16,0,"), all.find(",20,0,")) << all;
}

TEST_F(Recording, TakesEachNthRowOfASlave) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 3);
  for (std::uint64_t interval = 0; interval < 44; interval += 4) {
    rows.take(sample(0, interval, 1));
    rows.take(sample(3, interval + 3, 1));
  }
  static_cast<void>(rows.lines(true));
  EXPECT_EQ(rows.counts().rows, 8u) << "4 of 10 of each slave";
}

TEST_F(Recording, CountsTurnsWithoutARow) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  rows.set_polling(status);
  rows.take(sample(0, 4, 1));
  for (const std::uint64_t interval : {8u, 12u, 17u, 20u, 32u}) rows.take(sample(0, interval, 1));
  EXPECT_EQ(rows.counts().missing, 2u) << "24 and 28; a turn that comes an interval later is none";
  status.polling_two = 0;
  rows.set_polling(status);
  rows.take(sample(0, 33, 2));
  rows.take(sample(0, 36, 2));
  EXPECT_EQ(rows.counts().missing, 4u) << "asked in each interval";
  status.polling_one = status.polling_two = client::kNobody;
  rows.set_polling(status);
  rows.take(sample(0, 1000, 2));
  EXPECT_EQ(rows.counts().missing, 4u) << "nobody is asked";
}

TEST_F(Recording, WhatIsNotYetWrittenIsBounded) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  for (std::uint64_t interval = 0; interval < 1000; ++interval) {
    rows.take(sample(0, interval, 3));
    static_cast<void>(rows.lines(false));
  }
  const std::string rest = rows.lines(true);
  EXPECT_LE(std::count(rest.begin(), rest.end(), '\n'), 4);
}

/// The comments of a recording, without their time.
std::vector<std::string> comments(const std::string& lines) {
  std::vector<std::string> out;
  std::istringstream all(lines);
  const std::string begin = "# " + utc_text(kNoon) + ' ';
  for (std::string line; std::getline(all, line);)
    if (line.starts_with(begin)) out.push_back(line.substr(begin.size()));
  return out;
}

TEST_F(Recording, FollowsWhatAReloadMakesOfAValueAndSaysSo) {
  RecordPlan plan(slaves, {}, false);
  RecordRows rows(plan, 1);
  EXPECT_TRUE(rows.update(slaves[0], kNoon).empty()) << "as it was";
  rows.take(sample(0, 4, 1));
  rows.take(sample(0, 8, 3));
  client::SlaveStatus& changed = slaves[0];
  put(changed.name, "rewinder");
  changed.actual_value[0].factor = 0.5;
  changed.actual_value[0].offset = -3;
  put(changed.actual_value[4].name, "draw");
  const std::vector<std::string> said{
      "slave 0 is 'rewinder' from here on, and was 'unwinder'",
      "slave 0, value 0: from here on 'position [mm]' is number * 0.5 + -3",
      "slave 0, value 4: from here on it is 'draw [%]', for which the file has no column: it is not recorded"};
  EXPECT_EQ(rows.update(changed, kNoon), said);
  EXPECT_TRUE(rows.update(changed, kNoon).empty()) << "said once";
  rows.take(sample(0, 12, 3));
  const std::string all = rows.lines(true);
  EXPECT_EQ(comments(all), said);
  EXPECT_NE(all.find(",8,0,unwinder,-0.8,,-0.8\n#"), std::string::npos) << all;
  EXPECT_TRUE(all.ends_with(",12,0,rewinder,-1.2,,\n")) << all;

  put(changed.actual_value[4].name, "torque");
  EXPECT_EQ(rows.update(changed, kNoon),
            std::vector<std::string>{"slave 0, value 4: from here on it is 'torque [%]'"});
  changed.actual_mapping[2] = changed.actual_mapping[3] = 0;
  EXPECT_EQ(rows.update(changed, kNoon),
            std::vector<std::string>{"slave 0, value 4: from here on it is not mapped any more"});
}

TEST_F(Recording, AValueThatTakesTheNameOfAnotherGoesToItsColumn) {
  RecordPlan plan(slaves, {"position", "torque"}, true);
  RecordRows rows(plan, 1);
  rows.take(sample(0, 4, 3));
  put(slaves[0].actual_value[0].name, "torque");
  put(slaves[0].actual_value[4].name, "position");
  EXPECT_EQ(rows.update(slaves[0], kNoon),
            (std::vector<std::string>{"slave 0, value 0: from here on it is 'torque [raw]'",
                                      "slave 0, value 4: from here on it is 'position [raw]'"}));
  rows.take(sample(0, 8, 1));
  EXPECT_TRUE(rows.lines(true).ends_with(",8,0,unwinder,,-8\n"));
  slaves[0].actual_value[0].factor = 0.5;
  EXPECT_TRUE(rows.update(slaves[0], kNoon).empty()) << "numbers as on the bus have no factor";
  put(slaves[0].actual_value[0].name, "speed");
  EXPECT_TRUE(rows.update(slaves[0], kNoon).size() == 1) << "it is not among --values";
  EXPECT_FALSE(plan.column(0, 0));
}

TEST_F(Recording, ASlaveThatComesWithAReloadIsRecordedWhereItHasColumns) {
  RecordPlan plan(std::span<const client::SlaveStatus>(slaves).first(1), {}, false);
  RecordRows rows(plan, 1);
  rows.take(sample(3, 7, 1));
  put(slaves[1].name, "say \"x\"");
  const std::vector<std::string> said{
      "slave 3 is recorded from here on",
      "slave 3, value 0: from here on it is 'value0', for which the file has no column: it is not recorded"};
  EXPECT_EQ(rows.update(slaves[1], kNoon), said);
  put(slaves[1].actual_value[0].name, "position");
  put(slaves[1].actual_value[0].unit_symbol, "mm");
  EXPECT_EQ(rows.update(slaves[1], kNoon),
            std::vector<std::string>{"slave 3, value 0: from here on it is 'position [mm]'"});
  rows.take(sample(3, 11, 1));
  rows.take(sample(3, 15, 1));
  EXPECT_NE(rows.lines(true).find(",15,3,\"say \"\"x\"\"\",-1.5,\n"), std::string::npos);
}

TEST_F(Recording, AnotherStartOfTheDaemonIsACommentAndNothingIsMissingInBetween) {
  RecordPlan plan(slaves, {"position"}, true);
  RecordRows rows(plan, 1);
  rows.set_polling(status);
  rows.take(sample(0, 1000, 1));
  rows.take(sample(0, 1004, 1));
  rows.take(sample(0, 1008, 1));
  rows.restarted(kNoon);
  const std::string before = rows.lines(false);
  EXPECT_EQ(std::count(before.begin(), before.end(), '\n'), 3);
  EXPECT_NE(before.find(",1008,0,"), std::string::npos);
  EXPECT_EQ(before.substr(before.find('#')),
            "# " + utc_text(kNoon) + " the daemon was started anew, interval numbers begin again\n");
  rows.take(sample(0, 256, 1));
  rows.take(sample(0, 264, 1));
  const std::string after = rows.lines(true);
  EXPECT_NE(after.find(",256,0,"), std::string::npos);
  EXPECT_NE(after.find(",264,0,"), std::string::npos);
  EXPECT_EQ(rows.counts().rows, 4U);
  EXPECT_EQ(rows.counts().missing, 1U) << "the turn in interval 260";
}

TEST_F(Recording, TheCommentStandsBeforeTheFirstSampleOfTheNewStartHoweverLateItIsTold) {
  RecordPlan plan(slaves, {"position"}, true);
  RecordRows rows(plan, 1);
  rows.set_polling(status);
  for (const std::uint64_t interval : {1000u, 1004u, 12u, 16u}) rows.take(sample(0, interval, 1));
  rows.restarted(kNoon);
  rows.take(sample(0, 20, 1));
  const std::string all = rows.lines(true);
  EXPECT_EQ(std::count(all.begin(), all.end(), '#'), 1);
  const auto comment = all.find('#');
  EXPECT_LT(all.find(",1004,0,"), comment);
  for (const char* later : {",12,0,", ",16,0,", ",20,0,"}) {
    ASSERT_NE(all.find(later), std::string::npos) << later;
    EXPECT_GT(all.find(later), comment) << later;
  }
  EXPECT_EQ(rows.counts().missing, 0U);
  // The next start is told of again.
  rows.restarted(kNoon);
  const std::string next = rows.lines(true);
  EXPECT_EQ(std::count(next.begin(), next.end(), '#'), 1);
}

}  // namespace
}  // namespace cansync::cli
