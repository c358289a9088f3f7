#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cli/cansync/timing_report.h"
#include "cli/cansync/timing_svg.h"

namespace cansync::cli {
namespace {

LineFacts line() {
  return {"press<1>&co", 1'000'000, 1'000'000};
}

/// A sample in which every slot was seen once in each interval.
client::Timing sample(std::uint32_t seconds) {
  const std::int64_t n = seconds;
  const std::uint64_t count = seconds;
  client::Timing timing = {};
  timing.intervals = 1000 * count;
  timing.lateness_minimum = 10'000 * n;
  timing.lateness_mean = 20'000 * n;
  timing.lateness_maximum = 100'000 * n;
  timing.lateness_histogram[5] = 900 * seconds;
  timing.lateness_histogram[6] = 95 * seconds;
  timing.lateness_histogram[9] = 5 * seconds;
  timing.missed_syncs = 2 * count;
  timing.bus_load = 400 + 10 * seconds;
  std::snprintf(timing.timestamp_source, sizeof timing.timestamp_source, "%s", "simulation");
  const std::array<std::int64_t, 6> allowed{210'000, 350'000, 520'000, 650'000, 820'000, 950'000};
  const std::array<std::int64_t, 6> planned{-1, 300'000, -1, 600'000, -1, 900'000};
  for (std::size_t i = 0; i < 6; ++i) {
    const std::int64_t start = allowed[i] - 60'000;
    timing.slot[i] = {1000, start, start + 1'100 * n, start + 20'200 * n, planned[i], allowed[i], 3 * count};
  }
  timing.left_out[0] = 7 * count;
  timing.left_out[1] = 8 * count;
  timing.left_out[2] = 9 * count;
  return timing;
}

TimingReport since_the_start(const client::Timing& timing) {
  return timing_report(std::span(&timing, 1), nullptr, line());
}

TEST(TimingReport, WithoutASampleBeforeCountsAreThoseSinceTheStart) {
  const TimingReport report = since_the_start(sample(3));
  EXPECT_EQ(report.seconds, std::nullopt);
  EXPECT_EQ(report.intervals, 3000u);
  EXPECT_EQ(report.histogram[5], 2700u);
  EXPECT_EQ(report.slots[1].left_out, 21u);
  EXPECT_EQ(report.slots[2].left_out, std::nullopt) << "the slaves send it";
  EXPECT_EQ(report.slots[2].planned, std::nullopt);
  EXPECT_EQ(report.slots[3].planned, 600'000);
  EXPECT_EQ(report.slots[4].late, 9u);
}

TEST(TimingReport, OfSomeSecondsCountsAreDifferencesAndStartsAreMerged) {
  const client::Timing before = sample(1);
  std::vector<client::Timing> samples{sample(2), sample(3)};
  samples[1].slot[0].count = 0;  // nothing seen: its zeros mean nothing
  samples[1].slot[0].earliest = 0;
  samples[0].slot[1].count = 500;
  const TimingReport report = timing_report(samples, &before, line());
  EXPECT_EQ(report.seconds, 2u);
  EXPECT_EQ(report.intervals, 2000u);
  EXPECT_EQ(report.missed_syncs, 4u);
  EXPECT_EQ(report.histogram[6], 190u);
  EXPECT_EQ(report.lateness_minimum, 20'000);
  EXPECT_EQ(report.lateness_mean, 50'000);
  EXPECT_EQ(report.lateness_maximum, 300'000);
  EXPECT_EQ(report.bus_load, 425u);
  EXPECT_EQ(report.slots[0].count, 1000u);
  EXPECT_EQ(report.slots[0].earliest, 150'000);
  const SlotReport& one = report.slots[1];
  EXPECT_EQ(one.count, 1500u);
  EXPECT_EQ(one.mean, 290'000 + (500 * 2'200 + 1000 * 3'300) / 1500);
  EXPECT_EQ(one.latest, 290'000 + 60'600);
  EXPECT_EQ(one.late, 6u);
  EXPECT_EQ(one.left_out, 14u);
}

TEST(TimingReport, CountersThatWrappedAreStillDifferences) {
  client::Timing before = sample(1);
  client::Timing after = sample(2);
  before.lateness_histogram[5] = 0xFFFFFFF0u;
  after.lateness_histogram[5] = 0x10;
  EXPECT_EQ(timing_report(std::span(&after, 1), &before, line()).histogram[5], 0x20u);
}

TEST(Percentile, IsTheUpperBoundOfItsBucket) {
  std::array<std::uint64_t, kLatenessBuckets> histogram = {};
  EXPECT_EQ(percentile_us(histogram, 50), std::nullopt) << "no counts";
  histogram[5] = 50;
  histogram[6] = 40;
  histogram[9] = 9;
  histogram[15] = 1;
  EXPECT_EQ(percentile_us(histogram, 50), 32u);
  EXPECT_EQ(percentile_us(histogram, 50.5), 64u);
  EXPECT_EQ(percentile_us(histogram, 90), 64u);
  EXPECT_EQ(percentile_us(histogram, 99), 512u);
  EXPECT_EQ(percentile_us(histogram, 100), std::nullopt) << "the last bucket has no bound";
}

TEST(Histogram, BarsFitTheWidthAndSmallCountsAreSeen) {
  const TimingReport report = since_the_start(sample(1));
  for (const std::size_t width : {60u, 79u, 200u}) {
    const auto lines = histogram_lines(report, width);
    ASSERT_EQ(lines.size(), 5u) << "from the first class that has any to the last";
    EXPECT_EQ(lines[0].size(), width) << "the longest bar takes all there is";
    for (const std::string& line : lines) EXPECT_LE(line.size(), width);
    EXPECT_EQ(std::count(lines[4].begin(), lines[4].end(), '#'), 1);
    EXPECT_EQ(std::count(lines[2].begin(), lines[2].end(), '#'), 0);
  }
  EXPECT_EQ(histogram_lines(report, 60)[1], "    < 64 us         95   9.50 %  ##");
  EXPECT_LE(histogram_lines(report, 0)[0].size(), 40u);
}

TEST(Histogram, TellsWhenThereIsNothing) {
  TimingReport report = since_the_start(sample(1));
  report.histogram = {};
  EXPECT_EQ(histogram_lines(report, 79), std::vector<std::string>{"  no SYNC edge yet"});
}

TEST(SlotTable, TellsNumbersInMicroseconds) {
  TimingReport report = since_the_start(sample(1));
  report.slots[5].count = 0;
  const auto lines = slot_table(report).lines();
  const auto words = [](const std::string& line) {
    std::string out;
    for (const char c : line)
      if (c != ' ' || (!out.empty() && out.back() != ' ')) out += c;
    return out;
  };
  EXPECT_EQ(words(lines[0]), "RC slave 1000 - 150.0 151.1 170.2 210.0 3 -");
  EXPECT_EQ(words(lines[1]), "WRC1 master 1000 300.0 290.0 291.1 310.2 350.0 3 7");
  EXPECT_EQ(words(lines[5]), "CC master 0 900.0 - - - 950.0 3 9");
}

TEST(TimingJson, HasNullForWhatIsNotKnown) {
  TimingReport report = since_the_start(sample(1));
  report.slots[0].count = 0;
  const std::string text = report_object(report).text();
  EXPECT_NE(text.find(R"("seconds":null)"), std::string::npos);
  EXPECT_NE(text.find(R"("percentiles_us":{"p50":32,"p90":32,"p99":64,"max":512})"), std::string::npos)
      << text;
  EXPECT_NE(text.find(R"({"slot":"RC","count":0,"planned_ns":null,"earliest_ns":null,"mean_ns":null,)"
                      R"("latest_ns":null,"allowed_ns":210000,"late":3,"left_out":null})"),
            std::string::npos)
      << text;
}

/// Empty when every element of `xml` is closed in order and no stray '<' or '&' is in the text.
std::string not_well_formed(const std::string& xml) {
  std::vector<std::string> open;
  std::size_t at = xml.find("?>") + 2;
  while ((at = xml.find_first_of("<&", at)) != std::string::npos) {
    if (xml[at] == '&') {
      const std::string entity = xml.substr(at, xml.find(';', at) - at);
      if (entity != "&amp" && entity != "&lt" && entity != "&gt") return "entity " + entity;
      ++at;
      continue;
    }
    const std::size_t end = xml.find('>', at);
    if (end == std::string::npos) return "no end of " + xml.substr(at, 20);
    const std::string tag = xml.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string::npos) return "stray < before " + tag;
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) return "quotes of " + tag;
    at = end;
    if (tag.front() == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return "end of " + tag;
      open.pop_back();
    } else if (tag.back() != '/') {
      open.push_back(tag.substr(0, tag.find(' ')));
    }
  }
  return open.empty() ? "" : "open: " + open.back();
}

TEST(TimingSvg, IsWellFormedAndHoldsTheNumbers) {
  const std::string svg = timing_svg(since_the_start(sample(1)), "2026-01-02 03:04:05");
  EXPECT_EQ(not_well_formed(svg), "");
  EXPECT_NE(svg.find(">CANsync interval on bus press&lt;1&gt;&amp;co at 1000000 bit/s<"), std::string::npos);
  EXPECT_NE(svg.find(">2026-01-02 03:04:05; "), std::string::npos);
  for (const char* number :
       {">290.0<", ">291.1<", ">310.2<", ">350.0<", ">7<", ">170.2<", ">100.0<", ">1000<"})
    EXPECT_NE(svg.find(number), std::string::npos) << number;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(TimingSvg, DrawsStartsToScale) {
  const std::string svg = timing_svg(since_the_start(sample(1)), "");
  // The axis has 750 px for 1000 us from x = 170: WRC1 was started from 290.0 to 310.2 us, may be until 350.
  EXPECT_NE(svg.find(R"(<rect x="387.5" y="232.0" width="15.1" height="20.0" class="sent"/>)"),
            std::string::npos)
      << svg;
  EXPECT_NE(svg.find(R"(<line x1="432.5" y1="222.0" x2="432.5" y2="262.0" class="latest"/>)"),
            std::string::npos);
}

TEST(TimingSvg, HasRoomForStartsOutsideTheIntervalAndForNothingAtAll) {
  TimingReport report = since_the_start(sample(1));
  report.slots[0].earliest = -40'000;
  const std::string svg = timing_svg(report, "");
  EXPECT_NE(svg.find(">-100<"), std::string::npos) << "the axis begins a step before SYNC";
  EXPECT_EQ(not_well_formed(timing_svg(TimingReport{}, "")), "");
  EXPECT_EQ(timing_svg(TimingReport{}, "").find("nan"), std::string::npos);
}

}  // namespace
}  // namespace cansync::cli
