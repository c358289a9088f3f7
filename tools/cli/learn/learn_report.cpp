#include "cli/learn/learn_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cli/learn/learn_points.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"
#include "text/counts.h"

namespace cansync::cli {
namespace {

using observe::Learned;
using observe::Observation;
using observe::Step;
using observe::StepEnd;

constexpr auto kToTheLeft = Table::Align::left;
constexpr auto kToTheRight = Table::Align::right;
constexpr std::size_t kStepsShown = 20;

struct PlaceName {
  const char* name;
  Duration SlotTimes::*latest;
};
/// In the order of observe::Place; set-up has its commands before WRC1.
constexpr std::array<PlaceName, observe::kPlaces> kPlaceNames = {{
    {"RC", &SlotTimes::response},
    {"WRC1", &SlotTimes::reference_one},
    {"RDC1", &SlotTimes::actual_one},
    {"WRC2", &SlotTimes::reference_two},
    {"RDC2", &SlotTimes::actual_two},
    {"CC", &SlotTimes::command},
    {"CC setup", &SlotTimes::command},
    {"RC setup", nullptr},
}};

std::vector<Table::Column> heard_slot_columns() {
  return {{"TELEGRAM", kToTheLeft, "its channel; setup = before the first reference values"},
          {"COUNT", kToTheRight, "telegrams with an edge before them"},
          {"USUAL", kToTheRight, "start after the SYNC edge in us, most frequent"},
          {"EARLIEST", kToTheRight, "the earliest start in us"},
          {"LATEST", kToTheRight, "the latest start in us"},
          {"ALLOWED", kToTheRight, "the latest start the manual allows in us"}};
}

std::vector<Table::Column> heard_slave_columns() {
  return {{"SLAVE", kToTheRight, "number"},
          {"ASKED", kToTheRight, "commands sent to it"},
          {"ANSWERS", kToTheRight, "that fit the command before"},
          {"REFUSED", kToTheRight, "of those: with an error code"},
          {"SILENT", kToTheRight, "commands without an answer"},
          {"RESPONSE us", kToTheRight, "end of a command to start of its answer: shortest..longest"},
          {"RDC1", kToTheRight, "actual value telegrams, and their most words"},
          {"RDC2", kToTheRight, "likewise"},
          {"MISSED", kToTheRight, "asked for actual values, and none came"}};
}

std::vector<Table::Column> heard_word_columns() {
  return {{"FROM", kToTheLeft, "master, or a slave's number"},
          {"TELEGRAM", kToTheLeft, "its channel"},
          {"WORDS", kToTheRight, "most words it had"},
          {"THAT MOVE", kToTheLeft, "words with more than one value, 0 to 3"},
          {"ALWAYS 0", kToTheLeft, "words that never had another value"}};
}

std::string words_in_mask(std::uint8_t mask, unsigned words) {
  std::string out;
  for (unsigned i = 0; i < words; ++i)
    if (((mask >> i) & 1u) != 0) out += fmt::format("{}{}", out.empty() ? "" : " ", i);
  return out.empty() ? "-" : out;
}

unsigned most_words_of(const observe::TelegramUse& use) {
  unsigned words = 0;
  for (unsigned i = 1; i < use.by_words.size(); ++i)
    if (use.by_words[i] > 0) words = i;
  return words;
}

std::string_view step_end_words(StepEnd end) {
  switch (end) {
    case StepEnd::done:
      return "done";
    case StepEnd::refused:
      return "refused";
    case StepEnd::unanswered:
      return "no answer";
    case StepEnd::open:
      break;
  }
  return "not ended in the recording";
}

std::string sub_slave_words(SubSlave sub) {
  return sub.value == 0 ? "" : fmt::format(", sub-slave {}", sub.value);
}

std::string step_words(const observe::WriteStep& write) {
  const auto& command = write.command;
  const std::string error = write.end == StepEnd::refused
                                ? fmt::format(" (0x{:04X})", static_cast<std::uint16_t>(write.error))
                                : "";
  return fmt::format("write {} {} = {} ({}{}), {}{}", command.slave.value(), command.number.value(),
                     command.value,
                     command.kind == ParameterCommand::Kind::write_word ? "word" : "doubleword",
                     sub_slave_words(command.sub_slave), step_end_words(write.end), error);
}

std::string step_words(const observe::ActionStep& step) {
  const ActionCommand& action = step.action;
  const std::string to = format_slave_set(action.slaves.bits);
  if (action.command == kCommandControlWord) return fmt::format("control {} 0x{:04X}", to, action.data_word);
  return fmt::format("action {} to {}, byte 0x{:02X}, word 0x{:04X}", action.command, to, action.data_byte,
                     action.data_word);
}

std::string step_words(const observe::TransferStep& step) {
  const bool upload = step.direction == TransferInitialise::Direction::upload;
  const std::string error =
      step.end == StepEnd::refused ? fmt::format(" (0x{:04X})", static_cast<std::uint16_t>(step.error)) : "";
  return fmt::format("{} {} 0x{:X} {} in {}{}, {}{}", upload ? "upload" : "download", step.slave.value(),
                     step.address, text::counted(step.bytes, "byte"), text::counted(step.blocks, "block"),
                     sub_slave_words(step.sub_slave), step_end_words(step.end), error);
}

void write_heard_slots(Output& output, const Observation& observation) {
  Table table(heard_slot_columns());
  const SlotTimes& times = slot_times(observation.bit_rate);
  for (unsigned i = 0; i < observe::kPlaces; ++i) {
    const observe::SlotUse& use = observation.slot[i];
    const auto latest = kPlaceNames[i].latest;
    if (use.count == 0) continue;
    if (output.json()) {
      output.object(JsonObject()
                        .add("kind", "slot")
                        .add("telegram", kPlaceNames[i].name)
                        .add("count", use.count)
                        .add("usual_us", microseconds_of(use.usual))
                        .add("earliest_us", microseconds_of(use.earliest))
                        .add("latest_us", microseconds_of(use.latest)));
      continue;
    }
    table.add(
        {kPlaceNames[i].name, fmt::format("{}", use.count), fmt::format("{}", microseconds_of(use.usual)),
         fmt::format("{}", microseconds_of(use.earliest)), fmt::format("{}", microseconds_of(use.latest)),
         latest == nullptr ? "-" : fmt::format("{}", microseconds_of(times.*latest))});
  }
  if (output.json() || table.lines().empty()) return;
  output.line("");
  output.line(observation.sync_seen
                  ? "Slots, in us after SYNC:"
                  : "Slots, in us; without SYNC edges WRC1 is taken to stand at its place:");
  output.table(table);
}

void write_heard_slaves(Output& output, const Observation& observation, const Learned& learned) {
  Table table(heard_slave_columns());
  for (const SlaveNumber number : learned.slaves.value) {
    const observe::SlaveUse& use = observation.slave[number.value()];
    const observe::ResponseUse& response = use.response;
    const std::uint64_t missed = use.missed_actual[0] + use.missed_actual[1];
    if (output.json()) {
      output.object(JsonObject()
                        .add("kind", "slave")
                        .add("slave", unsigned{number.value()})
                        .add("commands", use.commands)
                        .add("answers", use.answers)
                        .add("busy", use.busy)
                        .add("refused", use.refused)
                        .add("unanswered", use.unanswered)
                        .add("stray", use.stray)
                        .add("response_shortest_us", microseconds_of(response.shortest))
                        .add("response_longest_us", microseconds_of(response.longest))
                        .add("slow_answers", response.slow)
                        .add("actual_1", use.actual[0].count)
                        .add("actual_2", use.actual[1].count)
                        .add("missed_actual", missed));
      continue;
    }
    const auto actual = [&use](unsigned c) {
      return use.actual[c].count == 0
                 ? "-"
                 : fmt::format("{} x {}", use.actual[c].count, most_words_of(use.actual[c]));
    };
    table.add(
        {fmt::format("{}", number.value()), fmt::format("{}", use.commands), fmt::format("{}", use.answers),
         fmt::format("{}", use.refused), fmt::format("{}", use.unanswered),
         response.count == 0
             ? "-"
             : fmt::format("{}..{}", microseconds_of(response.shortest), microseconds_of(response.longest)),
         actual(0), actual(1), fmt::format("{}", missed)});
  }
  if (output.json() || table.lines().empty()) return;
  output.line("");
  output.line("Slaves:");
  output.table(table);
}

void write_heard_words(Output& output, const Observation& observation, const Learned& learned) {
  Table table(heard_word_columns());
  const auto row = [&](const std::string& from, const char* telegram, const observe::TelegramUse& use) {
    if (use.count == 0) return;
    const unsigned words = most_words_of(use);
    const auto zero = static_cast<std::uint8_t>(~use.not_zero);
    if (output.json()) {
      output.object(JsonObject()
                        .add("kind", "words")
                        .add("from", from)
                        .add("telegram", telegram)
                        .add("words", words)
                        .add("moved_mask", unsigned{use.moved})
                        .add("not_zero_mask", unsigned{use.not_zero}));
    } else {
      table.add({from, telegram, fmt::format("{}", words), words_in_mask(use.moved, words),
                 words_in_mask(zero, words)});
    }
  };
  row("master", "WRC1", observation.reference[0]);
  row("master", "WRC2", observation.reference[1]);
  for (const SlaveNumber slave : learned.slaves.value) {
    row(fmt::format("{}", slave.value()), "RDC1", observation.slave[slave.value()].actual[0]);
    row(fmt::format("{}", slave.value()), "RDC2", observation.slave[slave.value()].actual[1]);
  }
  if (output.json() || table.lines().empty()) return;
  output.line("");
  output.line("Words of reference and actual values:");
  output.table(table);
}

void write_steps(Output& output, const Observation& observation, const ReportOptions& options) {
  if (observation.steps.empty()) return;
  if (!output.json()) {
    output.line("");
    output.line("What the master did, in s after the first frame:");
  }
  std::size_t shown = 0;
  for (const Step& step : observation.steps) {
    if (output.json()) {
      output.object(JsonObject()
                        .add("kind", "step")
                        .add("time_us", microseconds_of(step.at))
                        .add("in_operation", step.in_operation)
                        .add("count", step.count)
                        .add("text", step_text(step)));
      continue;
    }
    if (!options.all_steps && shown == kStepsShown) break;
    ++shown;
    const std::int64_t time = microseconds_of(step.at);
    output.line(fmt::format("{:>5}.{:06}  {}{}", time / 1'000'000, time % 1'000'000, step_text(step),
                            step.count > 1 ? fmt::format(", {}", text::counted(step.count, "time")) : ""));
  }
  const std::size_t more = observation.steps.size() - shown;
  if (!output.json() && more > 0) output.line(fmt::format("       and {} more; --steps shows them", more));
  if (observation.steps_over > 0)
    output.remark(fmt::format("{} left out for lack of room",
                              text::counted(observation.steps_over, "further step is", "further steps are")));
}

void write_head(Output& output, const Observation& observation) {
  const std::int64_t length = microseconds_of(observation.length);
  const double seconds = static_cast<double>(length) / 1e6;
  const double bits = seconds * slot_times(observation.bit_rate).bits_per_second;
  const auto load =
      bits > 0 ? static_cast<std::int64_t>(100.0 * static_cast<double>(observation.busy_bits) / bits) : 0;
  std::uint64_t none = 0;
  for (const std::uint64_t count : observation.no_telegram) none += count;
  if (output.json()) {
    output.object(JsonObject()
                      .add("kind", "recording")
                      .add("frames", observation.frames)
                      .add("length_us", length)
                      .add("sync_edges", observation.edges)
                      .add("intervals", observation.intervals)
                      .add("load_percent", load)
                      .add("error_frames", observation.error_frames)
                      .add("no_telegrams", none)
                      .add("intervals_without_references", observation.references_missing));
    return;
  }
  output.line(
      fmt::format("{} in {:.3f} s, {}, bus load {} %, {}, {}", text::counted(observation.frames, "frame"),
                  seconds, text::counted(observation.edges, "SYNC edge"), load,
                  text::counted(observation.error_frames, "error frame"), text::counted(none, "other")));
}

/// A table of points, or an object for each.
void write_points(Output& output, const std::vector<LearnedPoint>& points) {
  Table table(learned_columns());
  for (const LearnedPoint& point : points) {
    if (output.json()) {
      output.object(JsonObject()
                        .add("kind", "point")
                        .add("point", point.name)
                        .add("found", point.found)
                        .add("certainty", certainty_word(point.certainty))
                        .add("count", point.count)
                        .add("slave_mask", point.slaves));
      continue;
    }
    table.add({point.name, point.found, certainty_text(point.certainty, point.count)});
  }
  if (!output.json()) output.table(table);
}

}  // namespace

std::string step_text(const Step& step) {
  return std::visit([](const auto& what) { return step_words(what); }, step.what);
}

void write_other_protocol(Output& output, const Observation& observation, const Learned& learned) {
  auto points = learned_points(observation, learned);
  // What the frames are, and how their times are; every other point holds of a CANsync bus alone.
  points.resize(2);
  write_points(output, points);
  if (!output.json()) output.line("");
  write_head(output, observation);
}

void write_learn_report(Output& output, const Observation& observation, const Learned& learned,
                        const ReportOptions& options) {
  write_points(output, learned_points(observation, learned));
  write_heard_slots(output, observation);
  write_heard_slaves(output, observation, learned);
  write_heard_words(output, observation, learned);
  write_steps(output, observation, options);
  if (!output.json()) output.line("");
  write_head(output, observation);
}

std::string report_tables_help() {
  const auto part = [](const char* title, const std::vector<Table::Column>& columns) {
    std::vector<Explained> entries;
    entries.reserve(columns.size());
    for (const Table::Column& column : columns) entries.emplace_back(column.heading, column.help);
    return explanation(title, entries);
  };
  return part("Slots", heard_slot_columns()) + "\n\n" + part("Slaves", heard_slave_columns()) + "\n\n" +
         part("Words", heard_word_columns());
}

}  // namespace cansync::cli
