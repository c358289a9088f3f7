#include "plan.h"

#include <algorithm>
#include <utility>

namespace cansyncd::campaign {
namespace {

using cansync::Channel;
using cansync::Cursor;
using cansync::SlaveNumber;
using sim::FaultKind;

unsigned draw_count(Dice& dice) {
  const std::uint64_t size = dice.below(100);
  if (size < 60) return static_cast<unsigned>(dice.between(1, 3));
  if (size < 88) return static_cast<unsigned>(dice.between(4, 8));
  if (size < 97) return static_cast<unsigned>(dice.between(9, 16));
  return static_cast<unsigned>(dice.between(17, cansync::kSlaves));
}

/// Numbers without gaps, or any.
std::vector<unsigned> draw_numbers(Dice& dice, unsigned count) {
  std::vector<unsigned> numbers(cansync::kSlaves);
  for (unsigned i = 0; i < cansync::kSlaves; ++i) numbers[i] = i;
  if (dice.chance(300)) {
    for (std::size_t i = numbers.size() - 1; i > 0; --i) std::swap(numbers[i], numbers[dice.below(i + 1)]);
  }
  numbers.resize(count);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

Cursor draw_cursor(Dice& dice, const std::vector<unsigned>& numbers, unsigned not_automatic) {
  if (!dice.chance(not_automatic)) return {};
  if (dice.chance(250)) return {Cursor::Kind::nobody, {}};
  return {Cursor::Kind::fixed, *SlaveNumber::from(numbers[dice.below(numbers.size())])};
}

void draw_command_channel(Dice& dice, Plan& plan, const std::vector<unsigned>& numbers) {
  constexpr std::uint32_t kShares[] = {0, 2, 3, 8, 8, 20};
  cansync::CommandChannelSettings& channel = plan.settings.command_channel;
  channel.serving = dice.chance(300) ? cansync::Serving::scan : cansync::Serving::work_conserving;
  channel.minimum_share = dice.one_of(kShares);
  channel.control_word = draw_cursor(dice, numbers, 50);
  channel.parameter = draw_cursor(dice, numbers, 50);
  channel.transfer = draw_cursor(dice, numbers, 50);
  channel.parameter_queue = static_cast<std::uint16_t>(dice.between(2, 40));
  channel.transfer_queue = static_cast<std::uint16_t>(dice.between(1, 6));
  channel.command_monitoring = dice.between(10, 400) * plan.interval();
  channel.broadcast_queue = static_cast<std::uint16_t>(dice.between(1, 4));
  channel.parameter_monitoring = dice.between(10, 200) * plan.interval();
  channel.transfer_monitoring = dice.between(50, 500) * plan.interval();
  channel.repeat_unanswered_writes = dice.chance(150);
  channel.telegram_repeats = static_cast<std::uint8_t>(dice.below(3));
  channel.block_retries = static_cast<std::uint8_t>(dice.below(3));
  channel.address_step = dice.chance(200) ? 4 : 1;
}

void draw_master(Dice& dice, Plan& plan) {
  constexpr std::uint16_t kBlockLimits[] = {12, 60, 300, 300};
  cansync::MasterSettings& settings = plan.settings;
  settings.bit_rate = static_cast<cansync::BitRate>(dice.below(4));
  settings.send_margin = cansync::default_send_margin(settings.bit_rate);
  const std::vector<unsigned> numbers = draw_numbers(dice, draw_count(dice));
  for (const unsigned number : numbers) {
    settings.slaves[number].configured = true;
    settings.slaves[number].block_limit = dice.one_of(kBlockLimits);
    settings.slaves[number].actual_mapping = draw_mapping(dice);
  }
  draw_command_channel(dice, plan, numbers);
  settings.startup.enable = dice.chance(750) ? cansync::EnableRule::all_synchronized
                                             : static_cast<cansync::EnableRule>(dice.below(3));
  settings.startup.status_period = dice.between(10, 150) * plan.interval();
  // To the master a bus that gives every frame twice is a line of two drives a number; which_drive_test has those.
  settings.startup.on_duplicate = cansync::OnDuplicate::report;
  settings.startup.lost_after = static_cast<std::uint8_t>(dice.between(1, 5));
  settings.process.maximum_slave = *SlaveNumber::from(numbers.back());
  settings.process.reference_mapping = draw_reference_mapping(dice);
  for (Cursor& cursor : settings.process.polling) cursor = draw_cursor(dice, numbers, 300);
  settings.process.poll_without_reference = dice.chance(200);
  settings.process.full_length = dice.chance(800);
}

void draw_drives(Dice& dice, Plan& plan) {
  const cansync::MasterSettings& settings = plan.settings;
  const can::Time bit = cansync::slot_times(settings.bit_rate).bit_time();
  const bool fixed_upload = dice.chance(100);
  for (unsigned number = 0; number < cansync::kSlaves; ++number) {
    if (!settings.slaves[number].configured) continue;
    sim::DriveSettings drive;
    drive.slave.number = *SlaveNumber::from(number);
    drive.slave.bit_rate = settings.bit_rate;
    drive.slave.actual_mapping = settings.slaves[number].actual_mapping;
    drive.slave.reference_mapping = settings.process.reference_mapping;
    drive.lock_time = dice.between(3, 60) * plan.interval();
    if (dice.chance(300)) drive.processing_delay = static_cast<can::Time::rep>(dice.between(5, 20)) * bit;
    drive.misses_until_fault = static_cast<std::uint32_t>(dice.below(20));
    drive.edges_until_fault = static_cast<std::uint32_t>(dice.between(2, 20));
    drive.memory.size = 4096;
    drive.memory.address_step = settings.command_channel.address_step;
    drive.memory.busy_replies = dice.chance(200) ? static_cast<std::uint32_t>(dice.below(3)) : 0;
    drive.memory.upload_length = fixed_upload ? std::uint16_t{12} : std::uint16_t{0};
    plan.drives.push_back(drive);
  }
}

Window draw_window(Dice& dice, std::uint64_t last, std::uint64_t longest) {
  const std::uint64_t from = dice.between(1, last);
  return {from, std::min(last, from + dice.below(longest))};
}

void draw_disturbances(Dice& dice, Plan& plan) {
  constexpr unsigned kOften[] = {5, 20, 100, 500};
  const std::uint64_t faults = dice.chance(100) ? 0 : dice.between(1, 7);
  for (std::uint64_t i = 0; i < faults; ++i) {
    const FaultKind kind = draw_kind(dice, plan.faults);
    plan.faults.push_back(draw_fault(dice, kind, plan, plan.last_fault));
  }
  for (std::uint64_t i = dice.chance(300) ? dice.between(1, 3) : 0; i > 0; --i) {
    plan.power_cycles.push_back({dice.below(plan.drives.size()), dice.between(1, plan.last_fault)});
  }
  std::sort(plan.power_cycles.begin(), plan.power_cycles.end(),
            [](const PowerCycle& a, const PowerCycle& b) { return a.at < b.at; });
  for (std::uint64_t i = dice.chance(200) ? dice.between(1, 2) : 0; i > 0; --i) {
    plan.hangs.push_back(draw_window(dice, plan.last_fault, 200));
  }
  if (dice.chance(250)) {
    const bool skips = dice.chance(400);
    const can::Time most = skips ? can::Time(dice.between(1, 30) * plan.interval()) : plan.interval() / 4;
    plan.lateness.push_back({draw_window(dice, plan.last_fault, skips ? 50 : plan.last_fault),
                             skips ? 10 : dice.one_of(kOften), most});
  }
}

void draw_mix(Dice& dice, Mix& mix) {
  constexpr unsigned kOften[] = {0, 5, 20, 20, 100, 300};
  constexpr unsigned kRarely[] = {0, 0, 2, 5, 10};
  constexpr unsigned kReferences[] = {0, 300, 900, 1000, 1000};
  mix.parameters = dice.one_of(kOften);
  mix.transfers = dice.one_of(kOften) / 2;
  mix.control_words = dice.one_of(kOften) / 2;
  mix.broadcasts = dice.one_of(kOften) / 4;
  mix.settings = dice.one_of(kRarely);
  mix.modes = dice.chance(250) ? 4 : 0;
  mix.cancels = dice.one_of(kRarely) * 2;
  mix.departures = dice.one_of(kRarely);
  mix.bursts = dice.one_of(kRarely) / 2;
  mix.references = dice.one_of(kReferences);
}

/// From dice of its own: a schedule without any of this takes the course it took before there was any.
void draw_writers_and_stops(Plan& plan) {
  constexpr int kAges[] = {0, 3, 6, 40};  // intervals, which are whole milliseconds
  constexpr std::chrono::milliseconds kDeadlines[] = {
      std::chrono::milliseconds(0), std::chrono::milliseconds(0), std::chrono::milliseconds(60)};
  constexpr unsigned kOften[] = {10, 50, 200};
  Dice dice(plan.seed ^ 0x57095);
  if (dice.chance(500)) {
    for (std::uint64_t i = dice.between(2, 4); i > 0; --i) {
      plan.writers.strengths.push_back(static_cast<std::int32_t>(dice.below(4)));
    }
    if (dice.chance(200)) plan.writers.hold = static_cast<std::uint32_t>(dice.between(5, 40));
    plan.writers.maximum_age =
        std::chrono::duration_cast<std::chrono::milliseconds>(dice.one_of(kAges) * plan.interval());
    plan.writers.deadline = dice.one_of(kDeadlines);
    // Values grow old in the queue when the thread that takes them is held up.
    if (dice.chance(300)) {
      plan.lateness.push_back({draw_window(dice, plan.last_fault, 100), 20, 30 * plan.interval()});
    }
  }
  if (!dice.chance(400)) return;
  plan.mix.stop_words = dice.one_of(kOften);
  if (dice.chance(300)) plan.settings.command_channel.control_word = {Cursor::Kind::nobody, {}};
}

/// Limits of the first value of each telegram, in steps from one update to the next.
void draw_limits(Plan& plan) {
  constexpr std::int64_t kUpdate = 0x1'0001;
  Dice dice(plan.seed ^ 0x11317);
  if (!dice.chance(250)) return;
  // While values of another writer are refused the hold of a lost one goes on: whose values are right then
  // depends on what was refused.
  plan.writers.hold = 0;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    cansync::ReferenceLimits& limits = plan.settings.process.reference_limits[channel * cansync::kWords];
    const auto updates = [&](std::uint64_t least, std::uint64_t most) {
      return static_cast<std::int64_t>(dice.between(least, most)) * kUpdate;
    };
    if (dice.chance(700)) limits.max_step = updates(2, 60);
    if (dice.chance(300)) limits.minimum = updates(1, 40);
    if (dice.chance(300)) limits.maximum = updates(100, 2'000);
  }
}

bool moves_telegrams(FaultKind kind) noexcept {
  return kind == FaultKind::late || kind == FaultKind::corrupted || kind == FaultKind::duplicated ||
         kind == FaultKind::inject;
}

/// What was held up and answered meanwhile takes so many intervals to get off the bus.
constexpr std::uint64_t kBacklog = 100;
constexpr std::uint64_t kAftermath = 4 + kLatestIntervals;

}  // namespace

bool Plan::disturbed(std::uint64_t edge) const noexcept {
  const auto near = [edge](std::uint64_t from, std::uint64_t to) {
    return edge + 2 >= from && edge <= to + kBacklog;
  };
  return edge <= restless_until ||
         std::any_of(faults.begin(), faults.end(),
                     [&](const sim::Fault& f) { return moves_telegrams(f.kind) && near(f.from, f.to); }) ||
         std::any_of(lateness.begin(), lateness.end(),
                     [&](const Lateness& late) { return near(late.when.from, late.when.to); });
}

bool Plan::doubtful_answers(std::uint64_t from, std::uint64_t to) const noexcept {
  return std::any_of(faults.begin(), faults.end(), [&](const sim::Fault& fault) {
    const bool kind = fault.kind == FaultKind::late || fault.kind == FaultKind::duplicated;
    return kind && fault.from <= to && fault.to + kAftermath >= from;
  });
}

cansync::ProcessMapping draw_reference_mapping(Dice& dice) {
  cansync::ProcessMapping mapping = draw_mapping(dice);
  for (cansync::TelegramMapping& telegram : mapping) {
    telegram.word[1] = {true, true, telegram.word[0].value};
    for (unsigned word = 2; word < cansync::kWords; ++word) {
      if (telegram.word[word].value != telegram.word[0].value) telegram.word[word].high = true;
    }
  }
  return mapping;
}

cansync::ProcessMapping draw_mapping(Dice& dice) {
  cansync::ProcessMapping mapping = {cansync::default_mapping(Channel::one),
                                     cansync::default_mapping(Channel::two)};
  if (!dice.chance(400)) return mapping;
  for (unsigned channel = 0; channel < cansync::kChannels; ++channel) {
    for (unsigned word = 1; word < cansync::kWords; ++word) {
      if (dice.chance(300)) {
        mapping[channel].word[word] = {};
      } else {
        mapping[channel].word[word] = {true, dice.chance(500),
                                       static_cast<std::uint8_t>(std::uint64_t{channel} * 4 + dice.below(4))};
      }
    }
  }
  return mapping;
}

Plan draw_plan(std::uint64_t seed, std::uint64_t intervals) {
  Dice dice(seed);
  Plan plan;
  plan.seed = seed;
  draw_master(dice, plan);
  draw_drives(dice, plan);
  plan.last_fault = intervals != 0 ? intervals : dice.between(150, 600);
  plan.rare_looks = dice.chance(300);
  plan.target = dice.chance(900) ? StartTarget::active : StartTarget::setup;
  plan.sizes.requests = dice.chance(200) ? dice.between(4, 16) : 256;
  plan.sizes.terminals = terminals_for(plan.settings.command_channel, plan.sizes.requests);
  plan.sizes.reports = dice.chance(200) ? dice.between(2, 16) : 256;
  plan.transmit_queue = dice.chance(200) ? dice.between(1, 3) : 10;
  if (dice.chance(150)) plan.stop_at = dice.between(1, plan.last_fault);
  draw_disturbances(dice, plan);
  draw_mix(dice, plan.mix);
  draw_writers_and_stops(plan);
  draw_limits(plan);
  return plan;
}

}  // namespace cansyncd::campaign
