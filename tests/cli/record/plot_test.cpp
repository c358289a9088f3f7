#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <vector>

#include "cli/base/child_process.h"
#include "cli/record/plot_data.h"
#include "cli/record/plot_script.h"
#include "cli/text/csv.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

const std::string kHeader = "time,seconds,receive_time_ns,interval,slave,name,position [mm],torque [%]\n";
const std::string kRows =
    "t,0,1,2,0,unwinder,1.5,\n"
    "t,0.5,1,3,3,,2,-10\r\n"
    "t,1,1,4,0,unwinder,,20\n";

PlotData read(const std::string& text, const std::vector<std::string>& values = {},
              const std::string& slaves = "") {
  std::istringstream file(text);
  return read_recording(file, "line.csv", values, slaves);
}

/// What is said of a file that is wrong.
std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const CsvError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(Csv, FieldsComeBackAsTheyWere) {
  for (const std::string text : {"", "plain", "a,b", "\"", "say \"x\"", " °C "}) {
    std::istringstream file(csv_field(text) + ",1\n");
    CsvReader reader(file, "f");
    std::vector<CsvField> fields;
    ASSERT_TRUE(reader.next(fields));
    ASSERT_EQ(fields.size(), 2u);
    EXPECT_EQ(fields[0].text, text);
  }
  EXPECT_EQ(csv_field("a\nb"), "a b") << "a field cannot break a line";
}

TEST(PlotData, ReadsCurvesBySlaveAndValue) {
  const PlotData data = read(kHeader + kRows);
  ASSERT_EQ(data.panels.size(), 2u);
  EXPECT_EQ(data.panels[0].heading, "position [mm]");
  ASSERT_EQ(data.panels[1].curves.size(), 2u);
  EXPECT_EQ(data.panels[1].curves[0].first, "unwinder");
  EXPECT_EQ(data.panels[1].curves[1].first, "slave 3");
  EXPECT_EQ(data.panels[1].curves[0].second.points()[0].value, 20);
  EXPECT_EQ(data.rows, 3u);
  EXPECT_EQ(data.slaves, (std::vector<unsigned>{0, 3}));
}

TEST(PlotData, TakesTheValuesAndSlavesThatAreWanted) {
  const PlotData data = read(kHeader + kRows, {"position"}, "unwinder");
  ASSERT_EQ(data.panels.size(), 1u);
  EXPECT_EQ(data.panels[0].curves.size(), 1u);
  EXPECT_EQ(data.rows, 2u);
  EXPECT_THROW(read(kHeader + kRows, {"speed"}), UsageError);
  EXPECT_THROW(read(kHeader + kRows, {}, "winder"), UsageError);
}

TEST(PlotData, SaysWhereAFileIsWrong) {
  EXPECT_EQ(complaint(""),
            "line.csv: line 0, column 1: found nothing; expected a recording made by `cansync record`");
  EXPECT_EQ(
      complaint("a,b\n"),
      "line.csv: line 1, column 1: found 'a'; expected the heading 'time' of a recording made by `cansync "
      "record`");
  EXPECT_EQ(complaint(kHeader + "t,0,1,2,0,u,x,\n"),
            "line.csv: line 2, column 13: position [mm]: found 'x'; allowed: a number");
  EXPECT_EQ(complaint(kHeader + "t,0,1,2,32,u,1,\n"),
            "line.csv: line 2, column 9: slave: found '32'; allowed: 0..31");
  EXPECT_EQ(complaint(kHeader + kRows + "t,0,1\n"),
            "line.csv: line 5, column 5: found 3 fields; expected 8 as in line 1");
  EXPECT_EQ(complaint(kHeader + "t,0,1,2,0,\"u,1,\n"),
            "line.csv: line 2, column 11: found no quote at the end of this field");
  EXPECT_EQ(complaint(kHeader + "t,0,1,2,0,\"u\"x,1,\n"),
            "line.csv: line 2, column 14: found 'x' after the quote; allowed: a comma or the line's end");
  EXPECT_NE(complaint(kHeader + std::string(70'000, '1')).find("the line is too long"), std::string::npos);
}

TEST(PlotData, WhatWasBeingWrittenWhenTheRecordingWasKilledIsLeftOut) {
  const PlotData data = read(kHeader + kRows + "t,2,1,5,0,unwi");
  EXPECT_TRUE(data.broken_off);
  EXPECT_EQ(data.rows, 3u);
  EXPECT_FALSE(read(kHeader + kRows).broken_off);
}

TEST(Curve, KeepsPeaksHoweverLongItIs) {
  Curve curve;
  for (int i = 0; i < 1'000'000; ++i)
    curve.add({i * 0.001, i == 777'777 ? 50.0 : i == 333'333 ? -50.0 : 0.0});
  const auto points = curve.points();
  EXPECT_LE(points.size(), 2 * Curve::kMostStretches);
  EXPECT_GT(points.size(), Curve::kMostStretches / 2);
  const auto [least, most] =
      std::minmax_element(points.begin(), points.end(), [](auto& a, auto& b) { return a.value < b.value; });
  EXPECT_EQ(least->value, -50);
  EXPECT_EQ(most->value, 50);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](auto& a, auto& b) { return a.time < b.time; }));
}

TEST(PlotScript, NamesAreNothingButText) {
  PlotData data = read(kHeader + "t,0,1,2,0,\"a'b`id`\",1,\n");
  const std::string script = plot_script(data, "it's\n`id`", PlotFormat::svg);
  EXPECT_NE(script.find("title 'a''b\"id\"'"), std::string::npos) << script;
  EXPECT_NE(script.find("title 'it''s \"id\"'"), std::string::npos) << script;
  EXPECT_EQ(script.find('`'), std::string::npos);
}

TEST(ChildProcess, GivesInputAndTellsOutputAndEnd) {
  const ChildResult result = run_child({"sh", "-c", "cat; echo no >&2; exit 3"}, std::string(500'000, 'x'));
  EXPECT_EQ(result.output, std::string(500'000, 'x'));
  EXPECT_EQ(result.errors, "no\n");
  EXPECT_EQ(result.status, 3);
  EXPECT_EQ(run_child({"sh", "-c", "kill -9 $$"}, "").status, 128 + 9);
  EXPECT_THROW(run_child({"no-such-program-here"}, ""), NoProgram);
}

}  // namespace
}  // namespace cansync::cli
