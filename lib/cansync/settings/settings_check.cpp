#include "cansync/settings/settings_check.h"

#include <bit>
#include <string_view>
#include <utility>

namespace cansync {
namespace {

using Problems = std::vector<SettingProblem>;

constexpr Duration kLongestMonitoring = std::chrono::hours(24);
constexpr Duration kLongestListening = std::chrono::minutes(1);

void expect(Problems& problems, bool right, std::string field, std::string found, std::string allowed) {
  if (!right) problems.push_back({std::move(field), std::move(found), std::move(allowed)});
}

void expect_range(Problems& problems, std::string field, std::uint64_t value, std::uint64_t low,
                  std::uint64_t high) {
  expect(problems, value >= low && value <= high, std::move(field), std::to_string(value),
         std::to_string(low) + ".." + std::to_string(high));
}

std::string in_microseconds(Duration duration) {
  // Down to the nanosecond only where it matters: a value just outside its range must not read as inside.
  const auto nanoseconds = duration.count();
  if (nanoseconds % 1000 != 0) return std::to_string(nanoseconds) + " ns";
  return std::to_string(nanoseconds / 1000) + " us";
}

void expect_duration(Problems& problems, std::string field, Duration value, Duration low, Duration high) {
  expect(problems, value >= low && value <= high, std::move(field), in_microseconds(value),
         in_microseconds(low) + " .. " + in_microseconds(high));
}

std::string at(std::string_view array, std::size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

std::string describe(const WordMapping& word) {
  if (!word.assigned)
    return "unused, yet with value " + std::to_string(word.value) + (word.high ? " high" : "");
  return "value " + std::to_string(word.value);
}

void check_mapping(Problems& problems, const std::string& field, const ProcessMapping& mapping) {
  for (std::size_t telegram = 0; telegram < kChannels; ++telegram) {
    const unsigned first = telegram == 0 ? 0 : 4;
    for (std::size_t i = 0; i < kWords; ++i) {
      const WordMapping& word = mapping[telegram].word[i];
      const bool right = word.assigned ? word.value >= first && word.value < first + 4
                                       : word == WordMapping{};  // M 3.2.2.4: unused means all bits 0
      expect(problems, right, at(field, telegram) + "." + at("word", i), describe(word),
             "unused, or value " + std::to_string(first) + ".." + std::to_string(first + 3));
    }
  }
}

// The mapping may change while the line runs; what never stands in it is a slip.
void check_status_value(Problems& problems, std::string field, const SlaveSettings& slave) {
  const ActualWord& word = *slave.status_value;
  const bool mapped =
      position_of(slave.actual_mapping[0], word) || position_of(slave.actual_mapping[1], word);
  expect(problems, mapped, std::move(field),
         std::to_string(word.value) + (word.high ? ", high word" : ", low word"),
         "a word of the slave's mapping of actual values");
}

std::string list(SlaveMask slaves) {
  std::string text;
  for (const SlaveNumber slave : slaves) {
    if (!text.empty()) text += ", ";
    text += std::to_string(slave.value());
  }
  return text;
}

void check_slaves(Problems& problems, const MasterSettings& settings) {
  expect(problems, !settings.configured().empty(), "slaves", "none configured", "1..32 configured slaves");
  for (std::size_t i = 0; i < kSlaves; ++i) {
    const SlaveSettings& slave = settings.slaves[i];
    if (!slave.configured) continue;
    const std::string path = at("slaves", i);
    expect_range(problems, path + ".status_parameter", slave.status_parameter, 0, ParameterNumber::max);
    expect_range(problems, path + ".block_limit", slave.block_limit, 6, 4092);
    expect_range(problems, path + ".return_parameters", slave.return_count, 0, kListedParameters);
    expect_range(problems, path + ".expect", slave.expect_count, 0, kListedParameters);
    // Where addresses count doublewords, a block of another length would end between two of them.
    if (settings.command_channel.address_step == 4) {
      expect(problems, slave.block_limit % 4 == 0, path + ".block_limit", std::to_string(slave.block_limit),
             "a multiple of 4 bytes, because command_channel.address_step is 4");
    }
    check_mapping(problems, path + ".actual_mapping", slave.actual_mapping);
    if (slave.status_value) check_status_value(problems, path + ".status_value", slave);
  }
}

void check_cursor(Problems& problems, std::string field, const Cursor& cursor, SlaveMask configured) {
  if (cursor.kind != Cursor::Kind::fixed) return;
  expect(problems, configured.has(cursor.slave), std::move(field),
         "slave " + std::to_string(cursor.slave.value()),
         "a configured slave (" + list(configured) + "), automatic, or nobody");
}

// A slave above the maximum is never reached by a cursor that rises by itself.
void check_maximum_slave(Problems& problems, const MasterSettings& settings) {
  const SlaveMask configured = settings.configured();
  const CommandChannelSettings& channel = settings.command_channel;
  const auto automatic = [](const Cursor& cursor) { return cursor.kind == Cursor::Kind::automatic; };
  const bool used = automatic(settings.process.polling[0]) || automatic(settings.process.polling[1]) ||
                    automatic(channel.control_word) || automatic(channel.parameter) ||
                    automatic(channel.transfer);
  if (!used || configured.empty()) return;
  const auto highest = static_cast<std::uint64_t>(std::bit_width(configured.bits) - 1);
  expect_range(problems, "process.maximum_slave", settings.process.maximum_slave.value(), highest,
               SlaveNumber::max);
}

void check_process(Problems& problems, const MasterSettings& settings) {
  const ProcessSettings& process = settings.process;
  check_mapping(problems, "process.reference_mapping", process.reference_mapping);
  for (std::size_t i = 0; i < kChannels; ++i) {
    check_cursor(problems, at("process.polling", i), process.polling[i], settings.configured());
  }
  check_maximum_slave(problems, settings);
  expect_range(problems, "process.poll_nobody", process.poll_nobody, SlaveNumber::max + 1, 127);
  expect_range(problems, "process.release_limit", process.release_limit, 1, 0xFFFFFFFFu);
}

void check_command_channel(Problems& problems, const MasterSettings& settings, Duration interval) {
  const CommandChannelSettings& channel = settings.command_channel;
  const SlaveMask configured = settings.configured();
  // One share each for parameters and transfers: at 1 the two contradict each other.
  expect(problems, channel.minimum_share != 1 && channel.minimum_share <= 65535,
         "command_channel.minimum_share", std::to_string(channel.minimum_share),
         "0 (strict priority), or 2..65535 intervals");
  check_cursor(problems, "command_channel.control_word", channel.control_word, configured);
  check_cursor(problems, "command_channel.parameter", channel.parameter, configured);
  check_cursor(problems, "command_channel.transfer", channel.transfer, configured);
  expect_range(problems, "command_channel.parameter_queue", channel.parameter_queue, 1, 65535);
  expect_range(problems, "command_channel.transfer_queue", channel.transfer_queue, 1, 65535);
  expect_range(problems, "command_channel.broadcast_queue", channel.broadcast_queue, 1, 65535);
  expect_duration(problems, "command_channel.parameter_monitoring", channel.parameter_monitoring, interval,
                  kLongestMonitoring);
  expect_duration(problems, "command_channel.transfer_monitoring", channel.transfer_monitoring, interval,
                  kLongestMonitoring);
  expect_duration(problems, "command_channel.command_monitoring", channel.command_monitoring, interval,
                  kLongestMonitoring);
  expect(problems, channel.address_step == 1 || channel.address_step == 4, "command_channel.address_step",
         std::to_string(channel.address_step), "1 or 4 bytes per start address");
}

void check_startup(Problems& problems, const StartupSettings& startup, Duration interval) {
  // 0 is no command at all and 1 is taken by the control word (M 3.2.2.6).
  expect_range(problems, "startup.activate_command", startup.activate_command, kCommandControlWord + 1, 255);
  const Duration listen = startup.listen;
  expect(problems, listen == Duration{0} || (listen >= interval && listen <= kLongestListening),
         "startup.listen", in_microseconds(listen),
         in_microseconds(interval) + " (one interval) .. " + in_microseconds(kLongestListening));
  const Duration period = startup.status_period;
  expect(problems, period == Duration{0} || (period >= interval && period <= kLongestMonitoring),
         "startup.status_period", in_microseconds(period),
         "0 (never), or " + in_microseconds(interval) + " .. " + in_microseconds(kLongestMonitoring));
  expect_range(problems, "startup.lost_after", startup.lost_after, 1, 255);
}

}  // namespace

std::vector<SettingProblem> check(const MasterSettings& settings) {
  Problems problems;
  const auto rate = static_cast<std::size_t>(settings.bit_rate);
  if (rate >= kSlotTimes.size()) {  // every other limit depends on it
    expect_range(problems, "bit_rate", rate, 0, kSlotTimes.size() - 1);
    return problems;
  }
  const SlotTimes& slots = slot_times(settings.bit_rate);
  // A margin up to the first slot would move its telegram before the SYNC edge.
  expect(problems, settings.send_margin >= Duration{0} && settings.send_margin < slots.reference_one,
         "send_margin", in_microseconds(settings.send_margin),
         "0 us up to, not including, tWRC1 = " + in_microseconds(slots.reference_one));
  check_slaves(problems, settings);
  check_process(problems, settings);
  check_command_channel(problems, settings, slots.interval);
  check_startup(problems, settings.startup, slots.interval);
  return problems;
}

}  // namespace cansync
