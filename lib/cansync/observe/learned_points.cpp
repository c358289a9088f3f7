// What the command channel tells: activation, status words, jobs and transfers.
#include <algorithm>
#include <tuple>
#include <vector>

#include "cansync/observe/learned.h"

namespace cansync::observe {
namespace {

constexpr std::uint16_t kSynchronized = 0x8000;
/// An operation of so long without one read of a status word: they are not read in operation.
constexpr Duration kLongOperation = std::chrono::seconds(2);
/// Commands that stand in step by chance once in so many times do not tell in which order slaves are served.
constexpr double kChance = 200;
constexpr std::uint8_t kLastReserved = 127;
constexpr std::uint16_t kShortestBlockLimit = 6;

template <class T>
void point(Found<T>& out, T value, Certainty certainty, std::uint64_t count) {
  out = {value, count == 0 ? Certainty::not_seen : certainty, count};
}

void learn_activation(const Observation& observation, Learned& out) {
  const ActionCommand* chosen = nullptr;
  bool others = false;
  const auto reserved = [](const ActionCommand& action) { return action.command <= kLastReserved; };
  // First choice: in set-up a reserved action; then any but a control word; last, a reserved one later.
  for (const bool in_operation : {false, true}) {
    for (const Step& step : observation.steps) {
      const auto* what = std::get_if<ActionStep>(&step.what);
      if (what == nullptr || step.in_operation != in_operation) continue;
      const ActionCommand& action = what->action;
      if (action.command == kCommandControlWord || (in_operation && !reserved(action))) continue;
      if (chosen != nullptr && (action.command != chosen->command || action.data_byte != chosen->data_byte)) {
        others = others || !in_operation;
        if (reserved(*chosen) || !reserved(action)) continue;
        chosen = &action;
      }
      if (chosen == nullptr) chosen = &action;
    }
    if (chosen != nullptr) break;
  }
  if (chosen == nullptr) return;
  std::uint64_t count = 0;
  bool followed = false;
  for (const Step& step : observation.steps) {
    const auto* what = std::get_if<ActionStep>(&step.what);
    if (what == nullptr) continue;
    if (what->action.command == chosen->command && what->action.data_byte == chosen->data_byte)
      count += step.count;
  }
  for (const ParameterUse& use : observation.parameters)
    followed = followed || (use.bit_15_rose && !use.bit_15_fell && chosen->slaves.has(use.slave));
  point(out.activation, Activation{chosen->command, chosen->data_byte},
        followed && !others ? Certainty::seen : Certainty::inferred, count);
}

bool may_be_status(const ParameterUse& use) {
  return use.sub_slave == SubSlave{} && use.element == kValueElement;
}

/// The parameter whose bit 15 the master waits for.
Found<std::uint16_t> status_parameter_of(const std::vector<const ParameterUse*>& uses) {
  Found<std::uint16_t> out;
  const auto risen = std::count_if(uses.begin(), uses.end(),
                                   [](const auto* use) { return use->bit_15_rose && !use->bit_15_fell; });
  const ParameterUse* best = nullptr;
  const auto rank = [](const ParameterUse& use) {
    const bool has_bit =
        use.reads > 0 && ((use.set_up_reads > 0 ? use.set_up_value : use.value) & kSynchronized) != 0;
    const bool rose = use.bit_15_rose && !use.bit_15_fell;
    return std::tuple(rose, has_bit && use.set_up_reads > 0, use.set_up_reads, has_bit, use.periods);
  };
  for (const ParameterUse* use : uses) {
    if (use->set_up_reads == 0 && (use->periods < 2 || (use->value & kSynchronized) == 0)) continue;
    if (best == nullptr || rank(*use) > rank(*best)) best = use;
  }
  if (best == nullptr) return out;
  const bool sure = risen == 1 && best->bit_15_rose;
  point(out, best->number.value(), sure ? Certainty::seen : Certainty::inferred,
        std::max<std::uint64_t>(best->reads, best->set_up_reads));
  return out;
}

const ParameterUse* use_of(const Observation& observation, unsigned slave, std::uint16_t number) {
  for (const ParameterUse& use : observation.parameters)
    if (use.slave.value() == slave && use.number.value() == number && may_be_status(use)) return &use;
  return nullptr;
}

void learn_status(const Observation& observation, Learned& out) {
  const SlotTimes& times = slot_times(observation.bit_rate);
  std::uint32_t period = 0;
  std::uint64_t periods = 0;
  std::uint64_t told = 0;
  Duration last{};
  for (const SlaveNumber slave : out.slaves.value) {
    std::vector<const ParameterUse*> uses;
    for (const ParameterUse& use : observation.parameters)
      if (use.slave == slave && may_be_status(use)) uses.push_back(&use);
    LearnedSlave& learned = out.slave[slave.value()];
    learned.status_parameter = status_parameter_of(uses);
    const ParameterUse* use = learned.status_parameter.known()
                                  ? use_of(observation, slave.value(), learned.status_parameter.value)
                                  : nullptr;
    if (use == nullptr || use->reads == 0) continue;
    ++told;
    last = std::max(last, use->last_read.value_or(Duration{0}));
    if (use->periods > periods) periods = use->periods, period = use->period;
  }
  if (!observation.first_reference) return;
  last = std::max(last, *observation.first_reference);
  if (periods > 0)
    point(out.status_period, period * times.interval, Certainty::inferred, periods);
  else if (observation.length - last > kLongOperation)
    point(out.status_period, Duration{0}, Certainty::inferred, told);
}

/// The recording has the begin of the master's operation.
bool start_recorded(const Observation& observation, const Learned& out) {
  if (!out.activation.known() || !observation.first_reference) return false;
  if (observation.start_up_until) return true;
  return std::any_of(observation.steps.begin(), observation.steps.end(), [&](const Step& step) {
    const auto* what = std::get_if<ActionStep>(&step.what);
    return what != nullptr && !step.in_operation && what->action.command == out.activation.value.command;
  });
}

void learn_enable(const Observation& observation, Learned& out) {
  if (!start_recorded(observation, out)) return;
  if (observation.start_up_until)
    return point(out.enable, EnableRule::any, Certainty::inferred, std::uint64_t{1});
  bool synchronized = true;
  bool responding = true;
  std::uint64_t slaves = 0;
  for (const SlaveNumber slave : out.slaves.value) {
    const auto& number = out.slave[slave.value()].status_parameter;
    const ParameterUse* use = number.known() ? use_of(observation, slave.value(), number.value) : nullptr;
    if (use == nullptr || use->set_up_reads == 0) continue;
    ++slaves;
    synchronized = synchronized && (use->set_up_value & kSynchronized) != 0;
    responding = responding && use->answered_in_set_up;
  }
  point(out.enable,
        synchronized ? EnableRule::all_synchronized
        : responding ? EnableRule::all_responding
                     : EnableRule::any,
        Certainty::inferred, slaves);
}

void learn_serving(const Observation& observation, Learned& out) {
  const unsigned round = out.maximum_slave.value.value() + 1u;
  if (!out.maximum_slave.known() || round == 1 || observation.served.empty()) return;
  const auto turn = [round](const ServedCommand& command) {
    return static_cast<unsigned>((command.interval + std::uint64_t{kSlaves} * round - command.slave.value()) %
                                 round);
  };
  const unsigned first = turn(observation.served.front());
  const bool in_step = std::all_of(observation.served.begin(), observation.served.end(),
                                   [&](const ServedCommand& command) { return turn(command) == first; });
  double chance = 1;
  for (std::size_t i = 1; i < observation.served.size() && chance < kChance; ++i) chance *= round;
  if (in_step && chance < kChance) return;
  point(out.serving, in_step ? Serving::scan : Serving::work_conserving, Certainty::inferred,
        observation.served.size());
}

void learn_transfers(const Observation& observation, Learned& out) {
  std::uint64_t cancels = 0;
  std::uint64_t before = 0;
  std::uint64_t without = 0;
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveUse& use = observation.slave[i];
    cancels += use.cancels;
    before += use.transfers_before_cancel;
    if (use.answers > 0 && use.cancels == 0) ++without;
    if (use.continued_block >= kShortestBlockLimit)
      point(out.slave[i].block_limit, use.continued_block, Certainty::inferred, use.continued_blocks);
  }
  if (start_recorded(observation, out)) {
    const bool always = cancels > 0 && before == 0 && without == 0;
    if (always)
      point(out.cancel_at_start, true, Certainty::seen, cancels);
    else
      point(out.cancel_at_start, cancels > before + without, Certainty::inferred, cancels + before + without);
  }
  const std::uint64_t bytes = observation.address_bytes;
  const std::uint64_t doublewords = observation.address_doublewords;
  const bool four = doublewords > bytes;
  point(out.address_step, static_cast<std::uint8_t>(four ? 4 : 1),
        bytes == 0 || doublewords == 0 ? Certainty::seen : Certainty::inferred, four ? doublewords : bytes);
  point(out.allow_reserved_addresses, true, Certainty::seen,
        observation.low_addresses_taken + observation.low_addresses_refused);
  const std::uint64_t again = observation.writes_repeated;
  const std::uint64_t once = observation.writes_not_repeated;
  point(out.repeat_unanswered_writes, again > once, Certainty::inferred, std::max(again, once));
}

}  // namespace

void learn_commands(const Observation& observation, Learned& out) {
  learn_activation(observation, out);
  learn_status(observation, out);
  learn_enable(observation, out);
  learn_serving(observation, out);
  learn_transfers(observation, out);
}

}  // namespace cansync::observe
