#include "cli/learn/learn_compare.h"

#include <fmt/format.h>

#include <functional>
#include <stdexcept>

#include "cansync/config/file.h"
#include "cli/learn/learn_points.h"
#include "cli/text/column_help.h"
#include "cli/text/values.h"

namespace cansync::cli {
namespace {

using observe::Certainty;
using observe::Found;
using observe::Learned;

/// A recording has the lateness of both computers in its time stamps.
constexpr int kLatenessInBits = 10;  // bit times

class SettingsComparison {
 public:
  template <class T>
  void same(std::string option, const T& configured, const Found<T>& recorded,
            const std::function<std::string(const T&)>& text) {
    if (recorded.known() && !(configured == recorded.value))
      differs(std::move(option), text(configured), text(recorded.value), recorded.certainty, recorded.count);
  }
  void flag(std::string option, bool configured, const Found<bool>& recorded) {
    same<bool>(std::move(option), configured, recorded,
               [](const bool& value) { return std::string(value ? "true" : "false"); });
  }
  template <class T>
  void number(std::string option, T configured, const Found<T>& recorded) {
    same<T>(std::move(option), configured, recorded, [](const T& value) { return fmt::format("{}", value); });
  }
  void differs(std::string option, std::string configured, std::string recorded, Certainty certainty,
               std::uint64_t count) {
    out_.push_back({std::move(option), std::move(configured), std::move(recorded), certainty, count});
  }
  std::vector<LearnedDifference> take() { return std::move(out_); }

 private:
  std::vector<LearnedDifference> out_;
};

void compare_start(SettingsComparison& out, const MasterSettings& configured, const Learned& learned) {
  out.same<BitRate>("bus.bit_rate", configured.bit_rate, learned.bit_rate,
                    [](const BitRate& rate) { return fmt::format("{}", slot_times(rate).bits_per_second); });
  const Duration off = configured.send_margin - learned.send_margin.value;
  const Duration lateness = kLatenessInBits * slot_times(configured.bit_rate).bit_time();
  if (learned.send_margin.known() && (off > lateness || off < -lateness))
    out.differs("bus.send_margin_us", fmt::format("{}", microseconds_of(configured.send_margin)),
                fmt::format("{}", microseconds_of(learned.send_margin.value)), learned.send_margin.certainty,
                learned.send_margin.count);
  const StartupSettings& startup = configured.startup;
  const auto& activation = learned.activation;
  out.number<std::uint8_t>("startup.activate_command", startup.activate_command,
                           {activation.value.command, activation.certainty, activation.count});
  out.number<std::uint8_t>("startup.activate_data", startup.activate_data,
                           {activation.value.data, activation.certainty, activation.count});
  out.same<EnableRule>("startup.enable", startup.enable, learned.enable,
                       [](const EnableRule& rule) { return std::string(enable_text(rule)); });
  const Duration interval = slot_times(configured.bit_rate).interval;
  out.same<Duration>("startup.status_period_ms", startup.status_period / interval * interval,
                     learned.status_period,
                     [](const Duration& time) { return fmt::format("{}", microseconds_of(time) / 1000); });
}

void compare_process(SettingsComparison& out, const MasterSettings& configured, const Learned& learned) {
  const ProcessSettings& process = configured.process;
  const unsigned round = process.maximum_slave.value() + 1u;
  for (unsigned c = 0; c < kChannels; ++c) {
    // An automatic cursor over slave 0 alone asks slave 0.
    Cursor cursor = process.polling[c];
    if (cursor.kind == Cursor::Kind::automatic && round == 1) cursor = {Cursor::Kind::fixed, {}};
    out.same<Cursor>(fmt::format("process.polling_{}", c + 1), cursor, learned.polling[c], polled_text);
    const unsigned words = process.full_length ? kWords : process.reference_mapping[c].used_words();
    const auto& recorded = learned.reference_mapping[c];
    const unsigned seen = recorded.value.used_words();
    if (recorded.known() && words != seen)
      out.differs(fmt::format("bytes of WRC{}", c + 1), fmt::format("{}", 2 * words),
                  fmt::format("{}", 2 * seen), Certainty::seen, recorded.count);
  }
  out.same<SlaveNumber>("process.maximum_slave", process.maximum_slave, learned.maximum_slave,
                        [](const SlaveNumber& slave) { return fmt::format("{}", slave.value()); });
  out.flag("process.polling_apart", process.polling_apart, learned.polling_apart);
  out.number("process.poll_nobody", process.poll_nobody, learned.poll_nobody);
  out.flag("process.poll_without_reference", process.poll_without_reference, learned.poll_without_reference);
}

void compare_channel(SettingsComparison& out, const MasterSettings& configured, const Learned& learned) {
  const CommandChannelSettings& channel = configured.command_channel;
  out.same<Serving>("command_channel.serving", channel.serving, learned.serving, [](const Serving& serving) {
    return std::string(serving == Serving::scan ? "scan" : "work_conserving");
  });
  out.number("command_channel.address_step", channel.address_step, learned.address_step);
  out.flag("command_channel.cancel_at_start", channel.cancel_at_start, learned.cancel_at_start);
  out.flag("command_channel.repeat_unanswered_writes", channel.repeat_unanswered_writes,
           learned.repeat_unanswered_writes);
  out.flag("command_channel.allow_reserved_addresses", channel.allow_reserved_addresses,
           learned.allow_reserved_addresses);
}

void compare_slaves(SettingsComparison& out, const MasterSettings& configured, const Learned& learned) {
  out.same<SlaveMask>("slaves", configured.configured(), learned.slaves,
                      [](const SlaveMask& slaves) { return format_slave_set(slaves.bits); });
  for (const SlaveNumber number : configured.configured()) {
    const unsigned n = number.value();
    const SlaveSettings& slave = configured.slaves[n];
    const observe::LearnedSlave& recorded = learned.slave[n];
    out.number(fmt::format("slave.{}.status_parameter", n), slave.status_parameter,
               recorded.status_parameter);
    out.number(fmt::format("slave.{}.block_limit", n), slave.block_limit, recorded.block_limit);
    for (unsigned c = 0; c < kChannels; ++c) {
      const auto& actual = recorded.actual_mapping[c];
      const unsigned wanted = slave.actual_mapping[c].used_words();
      const unsigned came = actual.value.used_words();
      // More words than are mapped do no harm; with fewer the telegram is not taken.
      if (actual.known() && wanted > came)
        out.differs(fmt::format("slave.{}: bytes of RDC{}", n, c + 1), fmt::format("at least {}", 2 * wanted),
                    fmt::format("{}", 2 * came), Certainty::seen, actual.count);
    }
  }
}

std::vector<Table::Column> setting_difference_columns() {
  constexpr auto left = Table::Align::left;
  return {{"OPTION", left, "of the configuration, or a fact that options lead to"},
          {"CONFIGURED", left, "what the configuration makes of it"},
          {"RECORDED", left, "what the recorded master does"},
          {"HOW", left, "seen or inferred, as in the report"}};
}

}  // namespace

std::vector<LearnedDifference> learned_differences(const MasterSettings& configured, const Learned& learned) {
  SettingsComparison out;
  compare_start(out, configured, learned);
  compare_process(out, configured, learned);
  compare_channel(out, configured, learned);
  compare_slaves(out, configured, learned);
  return out.take();
}

MasterSettings settings_of_file(const std::string& path) {
  const cansyncd::ConfigFile file = cansyncd::load_config(path, {});
  if (!file.problems.empty())
    throw std::runtime_error(fmt::format("{}; `cansyncd --check {}` tells everything that is wrong",
                                         config::to_string(file.problems.front()), path));
  return file.config.master;
}

void write_differences(Output& output, const std::vector<LearnedDifference>& differences,
                       const std::string& path) {
  Table table(setting_difference_columns());
  for (const LearnedDifference& difference : differences) {
    if (output.json())
      output.object(JsonObject()
                        .add("kind", "difference")
                        .add("option", difference.option)
                        .add("configured", difference.configured)
                        .add("recorded", difference.recorded)
                        .add("certainty", certainty_word(difference.certainty))
                        .add("count", difference.count));
    else
      table.add({difference.option, difference.configured, difference.recorded,
                 certainty_text(difference.certainty, difference.count)});
  }
  if (output.json()) return;
  if (differences.empty())
    output.line(fmt::format("{} does all that the recording tells", path));
  else
    output.table(table);
}

std::string compare_table_help() {
  std::vector<Explained> entries;
  for (const Table::Column& column : setting_difference_columns())
    entries.emplace_back(column.heading, column.help);
  return explanation("With --compare", entries);
}

}  // namespace cansync::cli
