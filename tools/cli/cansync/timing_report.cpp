#include "cli/cansync/timing_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "text/counts.h"

namespace cansync::cli {
namespace {

using Histogram = std::array<std::uint64_t, kLatenessBuckets>;

constexpr std::array<std::string_view, kSlotCount> kNames{"RC", "WRC1", "RDC1", "WRC2", "RDC2", "CC"};
/// Where each slot stands in Timing.left_out; -1: the slaves send it.
constexpr std::array<int, kSlotCount> kLeftOut{-1, 0, -1, 1, -1, 2};

std::uint64_t sum(const Histogram& histogram) {
  std::uint64_t total = 0;
  for (const std::uint64_t count : histogram) total += count;
  return total;
}

SlotReport slot_report(std::size_t index, std::span<const client::Timing> samples,
                       const client::Timing* before) {
  const cansync_SlotTiming& newest = samples.back().slot[index];
  SlotReport slot;
  slot.name = kNames[index];
  slot.from_master = kLeftOut[index] >= 0;
  slot.latest_start = newest.latest_start;
  slot.late = newest.late - (before != nullptr ? before->slot[index].late : 0);
  if (slot.from_master) {
    const auto place = static_cast<std::size_t>(kLeftOut[index]);
    slot.planned = newest.planned_start;
    slot.left_out = samples.back().left_out[place] - (before != nullptr ? before->left_out[place] : 0);
  }
  double weighted = 0;
  for (const client::Timing& sample : samples) {
    const cansync_SlotTiming& seen = sample.slot[index];
    if (seen.count == 0) continue;
    slot.earliest = slot.count == 0 ? seen.earliest : std::min(slot.earliest, seen.earliest);
    slot.latest = slot.count == 0 ? seen.latest : std::max(slot.latest, seen.latest);
    slot.count += seen.count;
    weighted += static_cast<double>(seen.mean) * seen.count;
  }
  if (slot.count > 0) slot.mean = std::llround(weighted / static_cast<double>(slot.count));
  return slot;
}

/// Microseconds with one digit.
std::string microseconds(std::int64_t nanoseconds) {
  return fmt::format("{:.1f}", static_cast<double>(nanoseconds) / 1000.0);
}

std::string bucket_label(std::size_t bucket) {
  if (bucket + 1 == kLatenessBuckets) return fmt::format(">= {} us", 1u << (bucket - 1));
  return fmt::format("< {} us", 1u << bucket);
}

/// "< 32 us", or that it lies beyond the histogram.
std::string percentile_text(const Histogram& histogram, double percent) {
  if (const auto bound = percentile_us(histogram, percent)) return fmt::format("< {} us", *bound);
  return sum(histogram) == 0 ? "-" : bucket_label(kLatenessBuckets - 1);
}

std::string span_text(const TimingReport& report) {
  return report.seconds ? fmt::format("of {} s", *report.seconds) : "since the daemon started";
}

}  // namespace

LineFacts line_facts(const client::Client& client) {
  return {client.gateway_status().bus, client.bus_status().bit_rate, client.master_status().interval_length};
}

TimingReport timing_report(std::span<const client::Timing> samples, const client::Timing* before,
                           const LineFacts& line) {
  const client::Timing& newest = samples.back();
  TimingReport report;
  if (before != nullptr) report.seconds = static_cast<std::uint32_t>(samples.size());
  report.intervals = newest.intervals - (before != nullptr ? before->intervals : 0);
  report.missed_syncs = newest.missed_syncs - (before != nullptr ? before->missed_syncs : 0);
  for (std::size_t i = 0; i < kLatenessBuckets; ++i) {
    // 32-bit counters that may have wrapped meanwhile.
    const std::uint32_t earlier = before != nullptr ? before->lateness_histogram[i] : 0;
    report.histogram[i] = static_cast<std::uint32_t>(newest.lateness_histogram[i] - earlier);
  }
  report.lateness_minimum = newest.lateness_minimum;
  report.lateness_maximum = newest.lateness_maximum;
  double mean = 0;
  double load = 0;
  for (const client::Timing& sample : samples) {
    report.lateness_minimum = std::min(report.lateness_minimum, sample.lateness_minimum);
    report.lateness_maximum = std::max(report.lateness_maximum, sample.lateness_maximum);
    mean += static_cast<double>(sample.lateness_mean);
    load += sample.bus_load;
  }
  const auto count = static_cast<double>(samples.size());
  report.lateness_mean = std::llround(mean / count);
  report.bus_load = static_cast<std::uint32_t>(std::llround(load / count));
  for (std::size_t i = 0; i < kSlotCount; ++i) report.slots[i] = slot_report(i, samples, before);
  report.timestamp_source = newest.timestamp_source;
  report.bus = line.bus;
  report.bit_rate = line.bit_rate;
  report.interval_length = line.interval_length;
  return report;
}

std::optional<std::uint64_t> percentile_us(const Histogram& histogram, double percent) {
  const std::uint64_t total = sum(histogram);
  if (total == 0) return std::nullopt;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(static_cast<double>(total) * percent / 100.0));
  std::uint64_t below = 0;
  for (std::size_t i = 0; i + 1 < kLatenessBuckets; ++i) {
    below += histogram[i];
    if (below >= wanted) return std::uint64_t{1} << i;
  }
  return std::nullopt;
}

std::vector<std::string> histogram_lines(const TimingReport& report, std::size_t width) {
  constexpr std::size_t kLeast = 40;
  const Histogram& histogram = report.histogram;
  const std::uint64_t total = sum(histogram);
  if (total == 0) return {"  no SYNC edge yet"};
  std::size_t first = 0;
  std::size_t last = kLatenessBuckets - 1;
  while (histogram[first] == 0) ++first;
  while (histogram[last] == 0) --last;
  const std::uint64_t most = *std::max_element(histogram.begin(), histogram.end());
  std::vector<std::string> lines;
  for (std::size_t i = first; i <= last; ++i) {
    const double share = 100.0 * static_cast<double>(histogram[i]) / static_cast<double>(total);
    std::string line = fmt::format("{:>11} {:>10} {:>6.2f} %  ", bucket_label(i), histogram[i], share);
    const std::size_t room = std::max(width, kLeast) - line.size();
    const auto bar = static_cast<std::size_t>(static_cast<double>(room) * static_cast<double>(histogram[i]) /
                                              static_cast<double>(most));
    // What is there at all is to be seen.
    line.append(histogram[i] > 0 ? std::max<std::size_t>(bar, 1) : 0, '#');
    line.erase(line.find_last_not_of(' ') + 1);
    lines.push_back(line);
  }
  return lines;
}

std::vector<Table::Column> slot_columns() {
  constexpr auto left = Table::Align::left;
  constexpr auto right = Table::Align::right;
  return {
      {"SLOT", left, "the telegram: RC, WRC1, RDC1, WRC2, RDC2, CC, in the order of the interval"},
      {"BY", left, "who sends it: master or slave"},
      {"SEEN", right, "telegrams of that slot on the bus in run"},
      {"PLANNED", right, "when the master means to start it; - = a slave does"},
      {"EARLIEST", right,
       "earliest start: the end of the frame less its length; a negative one is an answer that began before "
       "SYNC"},
      {"MEAN", right, "mean of the starts"},
      {"LATEST", right, "latest start"},
      {"ALLOWED", right, "latest start by the specification"},
      {"LATE", right, "telegrams started after that"},
      {"LEFT OUT", right, "telegrams not sent because they would have been late"}};
}

Table slot_table(const TimingReport& report) {
  Table table(slot_columns());
  for (const SlotReport& slot : report.slots) {
    const auto seen = [&slot](std::int64_t time) { return slot.count > 0 ? microseconds(time) : "-"; };
    table.add({std::string(slot.name), slot.from_master ? "master" : "slave", fmt::format("{}", slot.count),
               slot.planned ? microseconds(*slot.planned) : "-", seen(slot.earliest), seen(slot.mean),
               seen(slot.latest), microseconds(slot.latest_start), fmt::format("{}", slot.late),
               slot.left_out ? fmt::format("{}", *slot.left_out) : "-"});
  }
  return table;
}

std::vector<std::string> report_lines(const TimingReport& report, std::size_t width) {
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("bus {} at {} bit/s, an interval takes {}; counts {}", report.bus, report.bit_rate,
                  text::duration_text(std::chrono::nanoseconds(report.interval_length)), span_text(report)));
  lines.push_back(fmt::format("SYNC wake-up: {} us least, {} us mean, {} us most late in the last {}",
                              microseconds(report.lateness_minimum), microseconds(report.lateness_mean),
                              microseconds(report.lateness_maximum),
                              report.seconds ? fmt::format("{} s", *report.seconds) : "second"));
  for (std::string& line : histogram_lines(report, width)) lines.push_back(std::move(line));
  const Histogram& histogram = report.histogram;
  lines.push_back(fmt::format("p50 {}, p90 {}, p99 {}, max {}", percentile_text(histogram, 50),
                              percentile_text(histogram, 90), percentile_text(histogram, 99),
                              percentile_text(histogram, 100)));
  lines.emplace_back();
  lines.push_back(fmt::format("Starts in us after SYNC, on the bus; instants by {}",
                              report.timestamp_source.empty() ? "-" : report.timestamp_source));
  const Table table = slot_table(report);
  lines.push_back(table.heading());
  for (std::string& line : table.lines()) lines.push_back(std::move(line));
  lines.emplace_back();
  lines.push_back(fmt::format("bus load {:.1f} %; SYNC edges missed: {}; {}", report.bus_load / 10.0,
                              report.missed_syncs, text::counted(report.intervals, "interval")));
  return lines;
}

JsonObject report_object(const TimingReport& report) {
  JsonArray histogram;
  for (const std::uint64_t count : report.histogram) histogram.add(count);
  JsonObject percentiles;
  for (const auto& [key, percent] : {std::pair{"p50", 50.0}, {"p90", 90.0}, {"p99", 99.0}, {"max", 100.0}}) {
    if (const auto bound = percentile_us(report.histogram, percent))
      percentiles.add(key, *bound);
    else
      percentiles.add_null(key);
  }
  JsonArray slots;
  for (const SlotReport& slot : report.slots) {
    const auto add = [](JsonObject& object, std::string_view key, bool known, std::int64_t value) {
      known ? object.add(key, value) : object.add_null(key);
    };
    JsonObject object;
    object.add("slot", slot.name).add("count", slot.count);
    add(object, "planned_ns", slot.planned.has_value(), slot.planned.value_or(0));
    add(object, "earliest_ns", slot.count > 0, slot.earliest);
    add(object, "mean_ns", slot.count > 0, slot.mean);
    add(object, "latest_ns", slot.count > 0, slot.latest);
    object.add("allowed_ns", slot.latest_start).add("late", slot.late);
    add(object, "left_out", slot.left_out.has_value(), static_cast<std::int64_t>(slot.left_out.value_or(0)));
    slots.add_json(object.text());
  }
  JsonObject object;
  object.add("bus", report.bus)
      .add("bit_rate", report.bit_rate)
      .add("interval_length_ns", report.interval_length);
  if (report.seconds)
    object.add("seconds", *report.seconds);
  else
    object.add_null("seconds");
  return object.add("intervals", report.intervals)
      .add("lateness_minimum_ns", report.lateness_minimum)
      .add("lateness_mean_ns", report.lateness_mean)
      .add("lateness_maximum_ns", report.lateness_maximum)
      .add("lateness_histogram", histogram)
      .add("percentiles_us", percentiles)
      .add("slots", slots)
      .add("missed_syncs", report.missed_syncs)
      .add("bus_load_permille", report.bus_load)
      .add("timestamp_source", report.timestamp_source);
}

}  // namespace cansync::cli
