#include "cansync/config/bus_budget.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "can/frame_length.h"
#include "cansync/settings/timing.h"
#include "text/counts.h"

namespace cansyncd {
namespace {

using cansync::Cursor;
using cansync::Duration;
using cansync::MasterSettings;
using cansync::SlotTimes;

constexpr unsigned kFullTelegram = 8;
constexpr unsigned kReadCommandBytes = 4;  ///< DLC of a parameter read (M 3.2.1.2)
constexpr unsigned kWordReplyBytes = 6;    ///< DLC of its answer with a word
constexpr unsigned kTransferStep = 6;      ///< bytes each body telegram carries

unsigned worst_bits(unsigned bytes) noexcept {
  return can::worst_case_bits(static_cast<std::uint8_t>(bytes));
}
unsigned least_bits(unsigned bytes) noexcept {
  return can::unstuffed_bits(static_cast<std::uint8_t>(bytes));
}

unsigned configured_slaves(const MasterSettings& master) noexcept {
  return static_cast<unsigned>(__builtin_popcount(master.configured().bits));
}

/// Most data bytes of WRC1 (0) or WRC2 (1).
unsigned reference_bytes(const MasterSettings& master, unsigned channel) noexcept {
  return master.process.full_length ? kFullTelegram
                                    : 2u * master.process.reference_mapping[channel].used_words();
}

/// Data bytes of the longest actual value telegram that a mapping asks for.
unsigned mapped_actual_bytes(const MasterSettings& master, unsigned channel) noexcept {
  unsigned words = 0;
  for (const auto& slave : master.slaves) {
    if (slave.configured) words = std::max<unsigned>(words, slave.actual_mapping[channel].used_words());
  }
  return 2 * words;
}

bool asks_somebody(const MasterSettings& master, unsigned channel) noexcept {
  return master.process.polling[channel].kind != Cursor::Kind::nobody;
}

/// The second of two automatic cursors is half a round ahead (M 3.1.1.1).
unsigned polling_apart(const MasterSettings& master) noexcept {
  const auto& process = master.process;
  const bool automatic =
      std::all_of(process.polling.begin(), process.polling.end(),
                  [](const Cursor& cursor) { return cursor.kind == Cursor::Kind::automatic; });
  return process.polling_apart && automatic ? (process.maximum_slave.value() + 2u) / 2 : 0;
}

unsigned polling_round(const MasterSettings& master, unsigned channel) noexcept {
  switch (master.process.polling[channel].kind) {
    case Cursor::Kind::automatic:
      return master.process.maximum_slave.value() + 1u;
    case Cursor::Kind::fixed:
      return 1;
    case Cursor::Kind::nobody:
      break;
  }
  return 0;
}

/// Intervals from one turn of a slave to the next when nothing else is waiting.
unsigned job_round(const MasterSettings& master, const Cursor& cursor) noexcept {
  const bool waits =
      master.command_channel.serving == cansync::Serving::scan && cursor.kind == Cursor::Kind::automatic;
  return waits ? master.process.maximum_slave.value() + 1u : 1u;
}

/// Telegrams of one block: initialise, then six bytes each.
unsigned block_telegrams(unsigned bytes) noexcept {
  return 1 + (bytes + kTransferStep - 1) / kTransferStep;
}

unsigned transfer_telegrams(unsigned bytes, unsigned block) noexcept {
  const unsigned rest = bytes % block;
  return bytes / block * block_telegrams(block) + (rest != 0 ? block_telegrams(rest) : 0);
}

std::vector<SlotBudget> slots_of(const BudgetInput& input, const SlotTimes& times) {
  const MasterSettings& master = input.master;
  std::vector<SlotBudget> slots;
  const auto add = [&](std::string_view name, unsigned bytes, Duration latest, Duration margin) {
    const unsigned bits = worst_bits(bytes);
    slots.push_back({name, bytes, bits, latest - margin, latest, latest + bits * times.bit_time()});
  };
  if (input.sync_frame_bytes) add("SYNC", *input.sync_frame_bytes, Duration{0}, Duration{0});
  add("RC", kFullTelegram, times.response, Duration{0});
  add("WRC1", reference_bytes(master, 0), times.reference_one, master.send_margin);
  if (asks_somebody(master, 0)) add("RDC1", kFullTelegram, times.actual_one, Duration{0});
  add("WRC2", reference_bytes(master, 1), times.reference_two, master.send_margin);
  if (asks_somebody(master, 1)) add("RDC2", kFullTelegram, times.actual_two, Duration{0});
  add("CC", kFullTelegram, times.command, master.send_margin);
  return slots;
}

/// How far the longest command, begun at its latest start, reaches into the next interval.
Duration command_tail(const SlotTimes& times) noexcept {
  return times.command + worst_bits(kFullTelegram) * times.bit_time() - times.interval;
}

void add_load(BusBudget& budget, const BudgetInput& input) {
  const MasterSettings& master = input.master;
  double bits = input.sync_frame_bytes ? least_bits(*input.sync_frame_bytes) : 0;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    bits += least_bits(reference_bytes(master, channel));
    if (asks_somebody(master, channel)) bits += least_bits(mapped_actual_bytes(master, channel));
  }
  const double read = least_bits(kReadCommandBytes) + least_bits(kWordReplyBytes);
  const auto permille = [&](double of) {
    return static_cast<unsigned>(std::lround(of * 1000 / budget.capacity_bits));
  };
  budget.typical = permille(bits + read);
  const Duration period = master.startup.status_period;
  if (period > Duration{0}) {
    bits += read * configured_slaves(master) * static_cast<double>(budget.interval.count()) /
            static_cast<double>(period.count());
  }
  budget.idle = permille(bits);
  unsigned worst = 0;
  for (const SlotBudget& slot : budget.slots) worst += slot.bits;
  budget.worst = permille(worst);
}

std::string us(Duration duration) {
  const auto nanoseconds = duration.count();
  return nanoseconds % 1000 == 0 ? fmt::format("{} us", nanoseconds / 1000)
                                 : fmt::format("{} ns", nanoseconds);
}

std::string ms(Duration duration) {
  return fmt::format("{} ms", std::chrono::ceil<std::chrono::milliseconds>(duration).count());
}

/// Sent earlier than the slave's telegram before it may start, a telegram can take its place on the bus.
void check_margin(std::vector<cansync::SettingProblem>& problems, const MasterSettings& master,
                  const SlotTimes& times) {
  struct Pair {
    std::string_view name;
    Duration latest;
    std::string_view before;
    Duration latest_before;
  };
  for (const Pair& pair : {Pair{"WRC1", times.reference_one, "RC", times.response},
                           Pair{"WRC2", times.reference_two, "RDC1", times.actual_one},
                           Pair{"CC", times.command, "RDC2", times.actual_two}}) {
    if (pair.latest - master.send_margin >= pair.latest_before) continue;
    problems.push_back(
        {"send_margin",
         fmt::format("{}, so that {} would be sent {} after SYNC, while {} may still start until {}",
                     us(master.send_margin), pair.name, us(pair.latest - master.send_margin), pair.before,
                     us(pair.latest_before)),
         fmt::format("0 us .. {}", us(std::min({times.reference_one - times.response,
                                                times.reference_two - times.actual_one,
                                                times.command - times.actual_two})))});
    return;
  }
}

/// Jobs whose monitoring time is over before their telegrams can all have been sent.
void check_jobs(std::vector<cansync::SettingProblem>& problems, const MasterSettings& master,
                const SlotTimes& times) {
  const auto& channel = master.command_channel;
  const unsigned round = job_round(master, channel.parameter);
  const Duration read = (round + 1) * times.interval;
  if (round > 1 && channel.parameter_monitoring < read) {
    problems.push_back(
        {"command_channel.parameter_monitoring",
         fmt::format("{}, while the parameter cursor needs {} of {} to come round and one for the answer",
                     ms(channel.parameter_monitoring), text::counted(round, "interval"), us(times.interval)),
         fmt::format("at least {}, or serving \"work_conserving\"", ms(read))});
  }
  unsigned block = 0;
  for (const auto& slave : master.slaves) {
    if (slave.configured) block = std::max<unsigned>(block, slave.block_limit);
  }
  const unsigned telegrams = block_telegrams(block);
  const unsigned transfer_round = job_round(master, channel.transfer);
  const Duration needed = (telegrams * transfer_round + 1) * times.interval;
  if (channel.transfer_monitoring < needed) {
    problems.push_back(
        {"command_channel.transfer_monitoring",
         fmt::format("{}, while a block of {} takes {}, one in {} of {}", ms(channel.transfer_monitoring),
                     text::counted(block, "byte"), text::counted(telegrams, "telegram"),
                     text::counted(transfer_round, "interval"), us(times.interval)),
         fmt::format("at least {}, or smaller blocks", ms(needed))});
  }
}

void check_status_period(std::vector<cansync::SettingProblem>& problems, const MasterSettings& master,
                         const SlotTimes& times) {
  const Duration period = master.startup.status_period;
  const unsigned slaves = configured_slaves(master);
  const Duration needed = slaves * times.interval;
  if (period == Duration{0} || period >= needed) return;
  problems.push_back({"startup.status_period",
                      fmt::format("{}, while {} take {} of {}, one command in each", ms(period),
                                  text::counted(slaves, "status word"), text::counted(slaves, "interval"),
                                  us(times.interval)),
                      fmt::format("0 (never), or at least {}", ms(needed))});
}

void check_sync_frame(std::vector<cansync::SettingProblem>& problems, const BudgetInput& input,
                      const SlotTimes& times) {
  if (!input.sync_frame_bytes) return;
  const unsigned bits = worst_bits(*input.sync_frame_bytes);
  const Duration end = command_tail(times) + bits * times.bit_time();
  if (end <= times.response) return;
  problems.push_back(
      {"sync",
       fmt::format(
           "a SYNC frame of {}, up to {} bits: behind the longest command of the interval before it ends {} "
           "after SYNC, while RC must start by {}",
           text::counted(*input.sync_frame_bytes, "byte"), bits, us(end), us(times.response)),
       fmt::format("a SYNC frame of at most {}",
                   text::counted((times.response - command_tail(times)) / times.bit_time(), "bit"))});
}

}  // namespace

BudgetInput budget_input(const Config& config) noexcept {
  if (!config.sync.uses_frame()) return {config.master, std::nullopt};
  return {config.master, std::uint8_t{0}};
}

BusBudget bus_budget(const BudgetInput& input) {
  const MasterSettings& master = input.master;
  const SlotTimes& times = cansync::slot_times(master.bit_rate);
  BusBudget budget;
  budget.bits_per_second = times.bits_per_second;
  budget.interval = times.interval;
  budget.capacity_bits = static_cast<unsigned>(times.interval / times.bit_time());
  budget.slots = slots_of(input, times);
  add_load(budget, input);
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    budget.polling_round[channel] = polling_round(master, channel);
  }
  budget.polling_apart = polling_apart(master);
  budget.parameter_round = job_round(master, master.command_channel.parameter);
  budget.transfer_round = job_round(master, master.command_channel.transfer);
  budget.parameter_least = (least_bits(kReadCommandBytes) + least_bits(kWordReplyBytes)) * times.bit_time();
  for (const auto& slave : master.slaves) {
    if (slave.configured && (budget.transfer_block == 0 || slave.block_limit < budget.transfer_block)) {
      budget.transfer_block = slave.block_limit;
    }
  }
  budget.transfer_intervals =
      transfer_telegrams(kTransferBytes, budget.transfer_block) * budget.transfer_round;
  budget.transfer_least = budget.transfer_intervals * times.interval;
  if (input.sync_frame_bytes) budget.sync_delay = command_tail(times);
  return budget;
}

std::vector<cansync::SettingProblem> check_budget(const BudgetInput& input) {
  std::vector<cansync::SettingProblem> problems;
  const SlotTimes& times = cansync::slot_times(input.master.bit_rate);
  check_margin(problems, input.master, times);
  check_sync_frame(problems, input, times);
  check_jobs(problems, input.master, times);
  check_status_period(problems, input.master, times);
  return problems;
}

}  // namespace cansyncd
