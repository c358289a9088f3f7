#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "live_rig.h"

namespace cansync::cli {
namespace {

using Points = std::vector<std::optional<double>>;
using Lines = std::vector<std::string>;
constexpr ScreenSize kWide{100, 16};

client::Timing timing(std::uint32_t seconds) {
  client::Timing timing = {};
  timing.intervals = 1000u * seconds;
  timing.lateness_histogram[5] = 990u * seconds;
  timing.lateness_histogram[6] = 10u * seconds;
  timing.lateness_maximum = 41'300;
  timing.bus_load = 500;
  timing.missed_syncs = 100;
  timing.left_out[0] = 3u * seconds;
  return timing;
}

client::Event event(const char* code, const char* text, gateway_EventSeverity severity) {
  client::Event event = {};
  event.time = kNoon;
  event.severity = severity;
  put(event.code, code);
  put(event.text, text);
  return event;
}

class LiveLayout : public testing::Test {
 protected:
  LiveLayout() {
    setenv("TZ", "UTC", 1);  // NOLINT(concurrency-mt-unsafe): this test has one thread
    tzset();
  }
  LiveRig rig{{"unwinder", "dancer", "infeed"}};
};

TEST_F(LiveLayout, ShowsTheLine) {
  for (int i = 0; i < 4; ++i) rig.look(i);
  rig.model.take(timing(1));
  rig.model.take(timing(2));
  rig.model.take(event("slave_lost", "slave 2 'infeed' does not answer", gateway_SEVERITY_ERROR));
  EXPECT_EQ(
      rig.screen({}, kWide),
      (Lines{
          " cansync  bus press: active   slaves 3: 3 synchronized, 3 released                         "
          "12:00:02",
          " SYNC 1 ms  missed 0  late 0  left out 3  wake-up max 41.3 us  p99.9 <64 us  p50 <32 us  "
          "(last 1 s)",
          " Bus load [██████████████████████████████░░░░░░░░░░░░░░░░░░░░░░░░░░░░░░] 50.0 % of 1000 kbit/s",
          " sorted by number",
          "NO^  NAME      STATE      STATUS   AGE ms   position mm                     torque %",
          "  0  unwinder  released   0x8007     2000             3           ▁▃▆█           2.5           "
          "▁▁▁▁",
          "  1  dancer    released   0x8007     2000             4           ▁▃▆█           2.5           "
          "▁▁▁▁",
          "  2  infeed    released   0x8007     2000             5           ▁▃▆█           2.5           "
          "▁▁▁▁",
          "",
          "",
          "",
          "",
          " LAST EVENTS",
          " 12:00:00  slave_lost                slave 2 'infeed' does not answer",
          "",
          " q quit  ? help  s sort  o order  / filter  p pause  r raw  <--> value  up/down slave",
      }));
}

TEST_F(LiveLayout, OnASmallScreenWholeWordsAreLeftOutAndTheCountsStandFirst) {
  rig.facts.bus = "a-bus-with-a-name-of-some-length";
  for (int i = 0; i < 4; ++i) rig.look(i);
  rig.model.take(timing(1));
  rig.model.take(timing(2));
  const Lines lines = rig.screen({}, {80, 24});
  EXPECT_EQ(lines[0], " a-bus-with-a-name-of-some-length: active   3 of 3 slaves released     12:00:02");
  EXPECT_EQ(lines[1], " SYNC 1 ms  missed 0  late 0  left out 3  wake-up max 41.3 us  (last 1 s)");
  EXPECT_EQ(lines[23], " q quit  ? help  s sort  o order  / filter  p pause  r raw  <--> value");
  EXPECT_EQ(rig.screen({}, {60, 24})[1], " SYNC 1 ms  missed 0  late 0  left out 3");
}

TEST_F(LiveLayout, ValuesGoBeforeTrendsAndAgesUnlessOneIsOld) {
  for (WatchRow& row : rig.rows) {
    for (unsigned i : {2u, 3u}) {
      row.status.actual_mapping[2 * i] = static_cast<std::uint8_t>(4 * i + 1);
      row.status.actual_mapping[2 * i + 1] = static_cast<std::uint8_t>(4 * i + 3);
      put(row.status.actual_value[i].name, i == 2 ? "speed" : "current");
    }
    row.shown = 0x0F;
    row.values->receive_time = kNoon + 2'000'000'000;
  }
  for (int i = 0; i < 4; ++i) rig.look(i);
  EXPECT_EQ(rig.screen({}, {80, 24})[4].substr(0, 34), "NO^  NAME      STATE      STATUS  ");
  EXPECT_NE(rig.screen({}, {80, 24})[4].find("torque %         speed"), std::string::npos)
      << rig.screen({}, {80, 24})[4];
  EXPECT_EQ(rig.screen({}, {80, 24})[4].find("AGE"), std::string::npos);
  EXPECT_EQ(rig.screen({}, {80, 24})[5].find("▁"), std::string::npos) << "no room for trends";
  EXPECT_NE(rig.screen({}, {140, 24})[5].find("▁"), std::string::npos) << "three values and their trends fit";
  ViewState by_age;
  by_age.sort = SortBy::age;
  EXPECT_NE(rig.screen(by_age, {80, 24})[4].find("AGE ms"), std::string::npos);
  rig.rows[1].values->receive_time = kNoon;
  rig.look(4);
  EXPECT_NE(rig.screen({}, {80, 24})[4].find("AGE ms"), std::string::npos) << "one is over a second old";
}

TEST_F(LiveLayout, ShowsAsciiAloneWhereTheTerminalHasNothingElse) {
  put(rig.rows[0].status.actual_value[0].unit_symbol, "°");  // the others have mm
  for (int i = 0; i < 4; ++i) rig.look(i);
  rig.model.take(timing(1));
  for (const std::string& line : rig.screen({}, kWide, Symbols::ascii))
    for (const char c : line) EXPECT_TRUE(c >= ' ' && c <= '~') << line;
  EXPECT_NE(rig.screen({}, kWide, Symbols::ascii)[5].find(" 3 ?"), std::string::npos) << "the unit";
}

TEST_F(LiveLayout, EveryLineFitsOnEveryScreen) {
  for (int i = 0; i < 70; ++i) rig.look(-1e9 * i);
  rig.model.take(timing(1));
  for (int i = 0; i < 200; ++i)
    rig.model.take(event("a_code_that_is_long", std::string(150, 'x').c_str(), gateway_SEVERITY_INFO));
  EXPECT_EQ(rig.model.events().size(), kLiveEvents);
  ViewState help;
  help.help = true;
  ViewState typing;
  typing.typing_filter = true;
  typing.filter = std::string(64, 'y');
  for (std::size_t columns = 1; columns < 180; columns += 3) {
    for (std::size_t rows = 1; rows < 50; rows += 2) {
      for (const ViewState& state : {ViewState{}, help, typing}) {
        const auto lines = live_lines(rig.model, state, {columns, rows}, Symbols::unicode);
        ASSERT_LE(lines.size(), rows);
        for (const StyledLine& line : lines) ASSERT_LE(line.width(), columns) << line.text();
      }
    }
  }
}

TEST_F(LiveLayout, SaysHowLargeTheTerminalIsToBe) {
  EXPECT_EQ(rig.screen({}, {59, 24}), (Lines{"At least 60 x 12 characters are needed,",
                                             "this terminal has 59 x 24.", "Make it larger, or press q."}));
  EXPECT_EQ(rig.screen({}, {60, 12}).size(), 12u);
}

TEST_F(LiveLayout, SaysFaultsInWordsBesideTheStatusWordAndMarksThem) {
  rig.rows[1].status.status_word = 0x8028;
  rig.rows[1].fault = "fault";
  rig.look(1);
  const auto lines = live_lines(rig.model, {}, {80, 24}, Symbols::ascii);
  const auto row = std::find_if(lines.begin(), lines.end(), [](const StyledLine& line) {
    return line.text().find("dancer") != std::string::npos;
  });
  ASSERT_NE(row, lines.end());
  EXPECT_NE(row->text().find("0x8028 fault"), std::string::npos) << row->text();
  const auto marked = [](const Span& span) {
    return span.style == Style::bad && span.text.starts_with("0x8028");
  };
  EXPECT_TRUE(std::any_of(row->spans.begin(), row->spans.end(), marked));
  rig.rows[1].fault.clear();
  rig.look(1);
  for (const std::string& line : rig.screen({}, {80, 24}))
    EXPECT_EQ(line.find("fault"), std::string::npos) << line;
}

TEST_F(LiveLayout, MarksWhatIsPausedFilteredAndRaw) {
  rig.look(1.5);
  ViewState state;
  state.paused = true;
  state.raw = true;
  state.filter = "DAN";
  const Lines lines = rig.screen(state, kWide);
  EXPECT_NE(lines[0].find("PAUSED at 12:00:00"), std::string::npos) << lines[0];
  EXPECT_EQ(lines[3], " sorted by number   only DAN  1 of 3 slaves   numbers as on the bus");
  EXPECT_NE(lines[4].find("position raw"), std::string::npos) << lines[4];
  EXPECT_NE(lines[5].find("dancer"), std::string::npos) << lines[5];
  EXPECT_NE(lines[5].find(" 2500 "), std::string::npos) << lines[5];
  EXPECT_EQ(lines[6], "");
}

TEST_F(LiveLayout, SaysThatTheDaemonHasGone) {
  rig.look(1);
  rig.model.set_daemon(false, "DDS domain 3");
  rig.look(2);
  const Lines lines = rig.screen({}, kWide);
  EXPECT_EQ(lines[3], " The daemon has gone; looking for it (DDS domain 3). What is shown is old.");
  EXPECT_EQ(rig.model.slaves()[0].values[0].trend.last(2), (Points{1.0, std::nullopt}));
}

TEST_F(LiveLayout, ValuesThatDoNotFitAreReachedThroughTheChosenOne) {
  rig.rows[0].fault = "reference values missing";  // takes the room of a value
  rig.look(1);
  ViewState state;
  const Lines first = rig.screen(state, {70, 16});
  EXPECT_NE(first[4].find("position mm"), std::string::npos) << first[4];
  EXPECT_EQ(first[4].find("torque"), std::string::npos) << first[4];
  EXPECT_NE(first[11].find("values further away: 1 (<- ->)"), std::string::npos) << first[11];
  state.value = 1;
  EXPECT_NE(rig.screen(state, {70, 16})[4].find("torque %"), std::string::npos);
}

TEST_F(LiveLayout, SlavesThatDoNotFitAreReachedThroughTheSelectedOne) {
  LiveRig many{std::vector<std::string>(30, "drive")};
  many.look(0);
  ViewState state;
  const Lines top = many.screen(state, {80, 16});
  EXPECT_EQ(top[5].substr(0, 3), "  0");
  EXPECT_NE(top[11].find("slaves 1 to 6 of 30"), std::string::npos) << top[11];
  state.selected = 29;
  const Lines bottom = many.screen(state, {80, 16});
  EXPECT_EQ(bottom[10].substr(0, 3), " 29");
  EXPECT_TRUE(live_lines(many.model, state, {80, 16}, Symbols::ascii)[10].highlighted);
}

TEST_F(LiveLayout, UnitsStandInTheCellsWhenSlavesDoNotAgree) {
  put(rig.rows[1].status.actual_value[1].unit_symbol, "Nm");
  rig.look(0);
  const Lines lines = rig.screen({}, kWide);
  EXPECT_NE(lines[4].find("value 1"), std::string::npos) << lines[4];
  EXPECT_NE(lines[5].find("2.5 %"), std::string::npos) << lines[5];
  EXPECT_NE(lines[6].find("2.5 Nm"), std::string::npos) << lines[6];
}

TEST_F(LiveLayout, TimingIsThatOfTheLastMinuteAndOfOneDaemon) {
  rig.look(0);
  for (std::uint32_t second = 1; second <= 100; ++second) rig.model.take(timing(second));
  EXPECT_EQ(rig.model.timing()->seconds, 60u);
  EXPECT_EQ(rig.model.timing()->intervals, 60'000u);
  rig.model.take(timing(1));
  EXPECT_EQ(rig.model.timing()->seconds, std::nullopt) << "the daemon was started again";
}

TEST(TrendLine, GoesFromTheLeastToTheGreatestPoint) {
  EXPECT_EQ(trend_line(Points{0.0, 7.0, 3.5}, 3, Symbols::unicode), "▁█▅");
  EXPECT_EQ(trend_line(Points{0.0, 7.0, 3.5}, 3, Symbols::ascii), "_'-");
  EXPECT_EQ(trend_line(Points{5.0, 5.0}, 4, Symbols::unicode), "  ▁▁") << "new points come in on the right";
  EXPECT_EQ(trend_line(Points{-1.0, std::nullopt, 1.0}, 3, Symbols::unicode), "▁ █");
  EXPECT_EQ(trend_line(Points{100.0, 1.0, 2.0}, 2, Symbols::unicode), "▁█")
      << "what is not shown does not count";
  EXPECT_EQ(trend_line(Points{}, 3, Symbols::unicode), "   ");
}

TEST(Trend, KeepsTheNewestPoints) {
  Trend trend;
  for (int i = 0; i < 1000; ++i) trend.add(i);
  EXPECT_EQ(trend.last(2), (Points{998.0, 999.0}));
  EXPECT_EQ(trend.last(500).size(), kTrendPoints);
}

TEST(LoadBar, IsFilledToItsShare) {
  EXPECT_EQ(load_bar(500, 10, Symbols::ascii), "#####.....");
  EXPECT_EQ(load_bar(2000, 4, Symbols::unicode), "████");
}

TEST(StyledText, CutsAndFitsCharactersNotBytes) {
  EXPECT_EQ(fitted("°C", 4, true), "  °C");
  EXPECT_EQ(fitted("°C and more", 4), "°C ~");
  StyledLine line;
  line.add("°°").add("°x", Style::bad).cut(3);
  EXPECT_EQ(line.spans, (std::vector<Span>{{"°°", Style::plain}, {"°", Style::bad}}));
  EXPECT_EQ(ascii("a°\n"), "a??");
}

}  // namespace
}  // namespace cansync::cli
