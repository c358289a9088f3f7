#include <fmt/format.h>

#include <algorithm>

#include "cli/learn/evidence_text.h"
#include "cli/scan/heard_line.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using observe::Census;
using observe::HeardSlave;
using observe::HeardTelegrams;

constexpr auto kHeardToTheRight = Table::Align::right;

/// "6", "4-8", "0 4 8" of a mask of lengths; "-" for none.
std::string lengths_words(std::uint16_t lengths) {
  return format_slave_set(lengths);
}

/// "1200 x 8"; "-" for none.
std::string heard_words(const HeardTelegrams& heard) {
  return heard.count == 0 ? "-" : fmt::format("{} x {}", heard.count, lengths_words(heard.lengths));
}

double milliseconds(Duration time) {
  return std::chrono::duration<double, std::milli>(time).count();
}

LinePoint rate_point(const HeardLine& line) {
  const auto& vote = line.census.interval;
  if (!line.bit_rate)
    return {"bit rate", "-", "nothing tells it: no interval is known, and the interface has no bit rate"};
  std::string found = fmt::format("{} bit/s", slot_times(*line.bit_rate).bits_per_second);
  std::string how;
  if (line.rate_source == RateSource::typed) how = "--bit-rate";
  if (line.rate_source == RateSource::interface) how = "the interface is set to it";
  if (line.rate_source == RateSource::tried) how = "of the four, the one at which frames came";
  if (line.rate_source == RateSource::interval) how = "told by the interval";
  if (line.rate_source != RateSource::interval && vote.votes > 0 && vote.bit_rate != *line.bit_rate)
    how += fmt::format("; its interval belongs to {} bit/s", slot_times(vote.bit_rate).bits_per_second);
  return {"bit rate", std::move(found), std::move(how)};
}

LinePoint interval_point(const Census& census) {
  const auto& vote = census.interval;
  if (vote.votes == 0)
    return {"interval", "-",
            census.stamps.bunched() ? "time stamps are bunched" : "no telegram comes regularly"};
  return {"interval", fmt::format("{:.3f} ms", milliseconds(vote.mean)),
          fmt::format("{} apart so, {} otherwise", vote.votes, vote.against)};
}

LinePoint sync_point(const Census& census) {
  if (census.edges == 0) return {"SYNC", "-", "no SYNC frame: no master runs, or SYNC has wires of its own"};
  return {"SYNC", fmt::format("{}", census.edges), "edges that a frame or the recording marks"};
}

LinePoint master_point(const Census& census) {
  if (!census.master()) return {"master", "no", "nobody sends what a master sends"};
  std::string how =
      fmt::format("WRC1 {}, WRC2 {}, commands {}, actions {}", heard_words(census.reference[0]),
                  heard_words(census.reference[1]), census.commands.count, census.actions.count);
  if (!census.second_master()) return {"master", "yes", std::move(how)};
  return {"master", "two or more", how + "; or recordings of two buses were merged"};
}

LinePoint slaves_point(const Census& census) {
  std::uint32_t sends = 0;
  std::uint32_t silent = 0;
  for (unsigned i = 0; i < kSlaves; ++i) {
    if (census.slave[i].sends()) sends |= 1u << i;
    if (!census.slave[i].sends() && census.slave[i].known()) silent |= 1u << i;
  }
  return {"slaves", format_slave_set(sends),
          silent == 0 ? "sent something" : "sent something; asked and silent: " + format_slave_set(silent)};
}

LinePoint load_point(const HeardLine& line) {
  const Census& census = line.census;
  const double seconds = std::chrono::duration<double>(census.length).count();
  const std::string how = fmt::format("{} in {:.3f} s", text::counted(census.frames, "frame"), seconds);
  if (!line.bit_rate || seconds <= 0.0) return {"load", "-", how};
  const double bits = seconds * slot_times(*line.bit_rate).bits_per_second;
  return {"load", fmt::format("{:.1f} %", 100.0 * static_cast<double>(census.busy_bits) / bits), how};
}

LinePoint adapter_point(const HeardLine& line) {
  if (!line.link.adapter.known())
    return {"adapter", "-", "a virtual interface, or a bus whose places are not known"};
  return {"adapter", can::text_of(line.link.adapter),
          line.pin ? fmt::format("bus.adapter = \"{}\" allows no other", can::text_of(*line.pin))
                   : "another interface has the same: bus.adapter cannot distinguish them"};
}

LinePoint foreign_point(const Census& census) {
  std::uint64_t frames = census.foreign_over;
  for (const auto& foreign : census.foreign) frames += foreign.count;
  if (census.frames == 0) return {"others", "-", "no frame was received"};
  if (frames == 0) return {"others", "none", "every frame is one of CANsync"};
  return {"others",
          (census.foreign_over > 0 ? "over " : "") + text::counted(census.foreign.size(), "identifier"),
          text::counted(frames, "frame that is none of CANsync", "frames that are none of CANsync")};
}

std::vector<Table::Column> slave_sound_columns() {
  return {{"SLAVE", kHeardToTheRight, "number"},
          {"ASKED", kHeardToTheRight, "commands to it"},
          {"ANSWERS", kHeardToTheRight, "answers, and how many data bytes they had"},
          {"POLLED 1", kHeardToTheRight, "reference telegrams of channel 1 that asked it for actual values"},
          {"RDC1", kHeardToTheRight, "actual value telegrams, and their data bytes"},
          {"POLLED 2", kHeardToTheRight, "likewise of channel 2"},
          {"RDC2", kHeardToTheRight, "likewise"}};
}

std::vector<Table::Column> foreign_columns() {
  return {{"IDENTIFIER", kHeardToTheRight, "of frames that are none of CANsync; eight digits: 29 bits"},
          {"FRAMES", kHeardToTheRight, "how many"},
          {"BYTES", kHeardToTheRight, "data bytes they had"}};
}

JsonArray lengths_array(std::uint16_t lengths) {
  JsonArray out;
  for (unsigned i = 0; i <= 8; ++i)
    if (((lengths >> i) & 1u) != 0) out.add(i);
  return out;
}

JsonObject slave_sound_object(unsigned number, const HeardSlave& slave) {
  return JsonObject()
      .add("kind", "slave")
      .add("slave", number)
      .add("asked", slave.asked)
      .add("answers", slave.answers.count)
      .add("answer_lengths", lengths_array(slave.answers.lengths))
      .add("polled_1", slave.polled[0])
      .add("actual_1", slave.actual[0].count)
      .add("actual_1_lengths", lengths_array(slave.actual[0].lengths))
      .add("polled_2", slave.polled[1])
      .add("actual_2", slave.actual[1].count)
      .add("actual_2_lengths", lengths_array(slave.actual[1].lengths));
}

void write_slave_sounds(Output& output, const Census& census) {
  Table table(slave_sound_columns());
  for (unsigned i = 0; i < kSlaves; ++i) {
    const HeardSlave& slave = census.slave[i];
    if (!slave.known()) continue;
    if (output.json())
      output.object(slave_sound_object(i, slave));
    else
      table.add({fmt::format("{}", i), fmt::format("{}", slave.asked), heard_words(slave.answers),
                 fmt::format("{}", slave.polled[0]), heard_words(slave.actual[0]),
                 fmt::format("{}", slave.polled[1]), heard_words(slave.actual[1])});
  }
  if (table.lines().empty()) return;
  output.line("");
  output.table(table);
}

void write_foreign_frames(Output& output, const Census& census) {
  Table table(foreign_columns());
  for (const auto& foreign : census.foreign) {
    const std::string identifier = identifier_text(foreign.identifier, foreign.extended);
    if (output.json())
      output.object(JsonObject()
                        .add("kind", "foreign")
                        .add("identifier", foreign.identifier)
                        .add("extended", foreign.extended)
                        .add("remote", foreign.remote)
                        .add("count", foreign.count)
                        .add("lengths", lengths_array(foreign.lengths)));
    else
      table.add({identifier, fmt::format("{}", foreign.count),
                 foreign.remote ? "remote" : lengths_words(foreign.lengths)});
  }
  if (table.lines().empty()) return;
  output.line("");
  output.table(table);
  if (census.foreign_over > 0)
    output.line(fmt::format("and {} of further identifiers", text::counted(census.foreign_over, "frame")));
}

/// What holds of a CANsync bus alone.
bool is_conclusion(const LinePoint& point) {
  return point.name == "interval" || point.name == "SYNC" || point.name == "master" || point.name == "slaves";
}

std::string columns_part(const char* title, const std::vector<Table::Column>& columns) {
  std::vector<Explained> entries;
  entries.reserve(columns.size());
  for (const Table::Column& column : columns) entries.emplace_back(column.heading, column.help);
  return explanation(title, entries);
}

}  // namespace

std::vector<LinePoint> heard_points(const HeardLine& line) {
  const Census& census = line.census;
  std::vector<LinePoint> points{{"protocol", protocol_text(census.evidence), evidence_text(census.evidence)},
                                {"time stamps", stamps_text(census.stamps), stamps_evidence(census.stamps)},
                                rate_point(line),
                                interval_point(census),
                                sync_point(census),
                                master_point(census),
                                slaves_point(census),
                                load_point(line),
                                {"error frames", fmt::format("{}", census.error_frames),
                                 census.error_frames == 0 ? "" : "cable, termination, or a wrong bit rate"},
                                foreign_point(census)};
  if (line.live) points.push_back(adapter_point(line));
  if (is_other_protocol(census.evidence, census.frames))
    for (LinePoint& point : points)
      if (is_conclusion(point)) point = {point.name, "-", "not derived: this does not look like CANsync"};
  return points;
}

std::vector<Table::Column> line_point_columns() {
  return {{"POINT", Table::Align::left, "a fact about the line"},
          {"FOUND", Table::Align::left, "what it is; - = nothing tells it"},
          {"HOW", Table::Align::left, "how it is known"}};
}

void write_heard_line(Output& output, const HeardLine& line) {
  Table table(line_point_columns());
  for (const LinePoint& point : heard_points(line)) {
    if (output.json())
      output.object(JsonObject()
                        .add("kind", "point")
                        .add("point", point.name)
                        .add("found", point.found)
                        .add("how", point.how));
    else
      table.add({point.name, point.found, point.how});
  }
  if (!output.json()) output.table(table);
  if (!is_other_protocol(line.census.evidence, line.census.frames)) write_slave_sounds(output, line.census);
  write_foreign_frames(output, line.census);
}

std::string heard_tables_help() {
  return columns_part("Slaves that are heard", slave_sound_columns()) + "\n\n" +
         columns_part("Others", foreign_columns());
}

}  // namespace cansync::cli
