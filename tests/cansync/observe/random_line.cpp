#include "cansync/observe/random_line.h"

#include <algorithm>
#include <bit>
#include <chrono>

namespace cansync::observe::support {
namespace {

using cansyncd::campaign::Dice;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// Intervals of so much time.
std::uint64_t intervals_of(Duration time, BitRate rate) {
  return static_cast<std::uint64_t>(time / slot_times(rate).interval);
}

TelegramMapping random_mapping(Dice& dice, Channel channel, unsigned least_words) {
  TelegramMapping mapping;
  const unsigned words = static_cast<unsigned>(dice.between(least_words, kWords));
  auto value = static_cast<std::uint8_t>(index(channel) * kWords);
  for (unsigned i = 0; i < words;) {
    const bool doubleword = i % 2 == 0 && i + 1 < words && dice.chance(600);
    mapping.word[i++] = {true, false, value};
    if (doubleword) mapping.word[i++] = {true, true, value};
    ++value;
  }
  return mapping;
}

Cursor random_cursor(Dice& dice, SlaveMask slaves) {
  if (dice.chance(650)) return {};
  if (dice.chance(300)) return {Cursor::Kind::nobody, {}};
  unsigned steps = static_cast<unsigned>(dice.below(32));
  SlaveNumber chosen = *slaves.begin();
  while (steps-- > 0)
    for (const SlaveNumber slave : slaves)
      if (dice.chance(200)) chosen = slave;
  return {Cursor::Kind::fixed, chosen};
}

SlaveMask random_slaves(Dice& dice) {
  SlaveMask slaves;
  const auto count = dice.chance(150) ? dice.between(9, 31) : dice.between(1, 8);
  while (static_cast<unsigned>(std::popcount(slaves.bits)) < count)
    slaves.set(*SlaveNumber::from(dice.below(count > 8 ? 32 : 12)));
  return slaves;
}

void set_process(Dice& dice, SlaveMask slaves, sim::MasterNodeSettings& out) {
  ProcessSettings& process = out.master.process;
  process.reference_mapping = {random_mapping(dice, Channel::one, 1), random_mapping(dice, Channel::two, 1)};
  for (Cursor& cursor : process.polling) cursor = random_cursor(dice, slaves);
  unsigned highest = 0;
  for (const SlaveNumber slave : slaves) highest = slave.value();
  process.maximum_slave = *SlaveNumber::from(dice.chance(700) ? highest : dice.between(highest, 31));
  process.polling_apart = dice.chance(300);
  process.poll_nobody = static_cast<std::uint8_t>(dice.between(32, 127));
  process.full_length = dice.chance(500);
  process.poll_without_reference = dice.chance(300);
  const bool second = dice.chance(800);
  for (unsigned c = 0; c < kChannels; ++c) {
    if (c == 1 && !second) continue;
    // Values that a word can carry, too.
    for (unsigned v = 0; v < 4; ++v) {
      sim::ReferenceCurve& curve = out.references[c * 4 + v];
      curve.kind = dice.chance(500) ? sim::ReferenceCurve::Kind::sine : sim::ReferenceCurve::Kind::constant;
      curve.offset = static_cast<std::int64_t>(dice.below(2000)) + 1500;
      curve.amplitude = 1000;
      curve.period = static_cast<std::uint32_t>(dice.between(100, 500));
    }
  }
}

void set_start(Dice& dice, SlaveMask slaves, MasterSettings& out) {
  StartupSettings& startup = out.startup;
  constexpr EnableRule kRules[] = {EnableRule::all_synchronized, EnableRule::all_responding, EnableRule::any};
  startup.enable = dice.one_of(kRules);
  startup.census = false;  // as most masters that are recorded
  startup.activate_command = static_cast<std::uint8_t>(dice.between(2, 127));
  startup.activate_data = static_cast<std::uint8_t>(dice.below(256));
  // With room for jobs between the reads.
  const Duration least = 3 * std::popcount(slaves.bits) * slot_times(out.bit_rate).interval;
  startup.status_period =
      dice.chance(300) ? Duration{0} : std::max<Duration>(milliseconds(dice.between(60, 250)), least);
  const auto status = static_cast<std::uint16_t>(dice.chance(500) ? 301 : dice.between(2000, 3500));
  CommandChannelSettings& channel = out.command_channel;
  channel.serving = dice.chance(500) ? Serving::scan : Serving::work_conserving;
  channel.cancel_at_start = dice.chance(600);
  channel.address_step = dice.chance(500) ? 1 : 4;
  channel.repeat_unanswered_writes = dice.chance(500);
  channel.allow_reserved_addresses = dice.chance(400);
  constexpr std::uint16_t kBlocks[] = {12, 24, 60, 96, 120, 300};
  for (const SlaveNumber number : slaves) {
    SlaveSettings& slave = out.slaves[number.value()];
    slave.configured = true;
    slave.status_parameter = static_cast<std::uint16_t>(status + (dice.chance(200) ? 500 : 0));
    slave.block_limit = dice.one_of(kBlocks);
    slave.actual_mapping = {random_mapping(dice, Channel::one, 0), random_mapping(dice, Channel::two, 0)};
  }
}

class Routines {
 public:
  Routines(Dice& dice, SlaveMask slaves, sim::MasterNodeSettings& out)
      : dice_(dice), slaves_(slaves), out_(out) {}

  /// Jobs that do not meet: each has ended when the next one begins.
  void add_all(std::uint64_t from, std::uint64_t until) {
    constexpr std::uint64_t kApart = 80;
    for (std::uint64_t at = from; at + 8 * kApart < until; at += kApart) {
      if (dice_.chance(500)) add(write(), at);
      if (dice_.chance(150)) add(control_word(), at + 40);
      if (dice_.chance(80)) add(broadcast(), at + 40);
      if (dice_.chance(250)) at = add_transfer(at, until - 8 * kApart);
    }
    if (out_.master.command_channel.allow_reserved_addresses) {
      TransferRequest request = transfer(8);
      request.address = static_cast<std::uint32_t>(dice_.below(256));
      request.direction = TransferInitialise::Direction::upload;
      add(request, until - 7 * kApart);
    }
  }

 private:
  SlaveNumber slave() {
    auto left = dice_.below(static_cast<std::uint64_t>(std::popcount(slaves_.bits)));
    for (const SlaveNumber number : slaves_)
      if (left-- == 0) return number;
    return *slaves_.begin();
  }
  void add(sim::MasterRoutine::Request request, std::uint64_t at) {
    out_.routines.push_back({at, 0, std::move(request)});
  }
  ParameterRequest write() {
    ParameterRequest request;
    request.slave = slave();
    request.write = dice_.chance(800);
    const bool doubleword = dice_.chance(500);
    request.number = *ParameterNumber::from((doubleword ? 1020 : 1000) + dice_.below(20));
    request.format = doubleword ? ParameterFormat::doubleword : ParameterFormat::word;
    if (dice_.chance(100)) request.number = *ParameterNumber::from(1900);  // there is none
    request.value = static_cast<std::uint32_t>(dice_.below(doubleword ? 0x100000000u : 0x10000u));
    return request;
  }
  ControlWordRequest control_word() {
    return {0, slave(), static_cast<std::uint16_t>(dice_.below(16)), {}, false};
  }
  BroadcastRequest broadcast() {
    BroadcastRequest request;
    request.action = {SlaveMask::all(), static_cast<std::uint8_t>(dice_.between(129, 255)),
                      static_cast<std::uint8_t>(dice_.below(256)),
                      static_cast<std::uint16_t>(dice_.below(65536))};
    return request;
  }
  TransferRequest transfer(std::size_t bytes) {
    auto block = std::make_shared<std::vector<std::uint8_t>>(bytes);
    for (std::uint8_t& byte : *block) byte = static_cast<std::uint8_t>(dice_.below(256));
    out_.blocks.push_back(block);
    TransferRequest request;
    request.slave = slave();
    request.direction =
        dice_.chance(600) ? TransferInitialise::Direction::download : TransferInitialise::Direction::upload;
    request.address = static_cast<std::uint32_t>(dice_.between(0x100, 0x180));
    request.data = *block;
    return request;
  }
  /// The interval in which it has surely ended.
  std::uint64_t add_transfer(std::uint64_t at, std::uint64_t until) {
    const std::size_t bytes = 4 * dice_.between(1, 40);
    TransferRequest request = transfer(bytes);
    const std::uint64_t round = out_.master.process.maximum_slave.value() + 1u;
    const bool scan = out_.master.command_channel.serving == Serving::scan;
    const std::uint64_t telegrams = bytes / 6 + 2 + 2 * (bytes / 12 + 1);
    const std::uint64_t end = at + telegrams * (scan ? round : 2);
    if (end > until) return at;
    add(request, at);
    return end;
  }

  Dice& dice_;
  SlaveMask slaves_;
  sim::MasterNodeSettings& out_;
};

void add_drives(Dice& dice, SlaveMask slaves, RandomLine& line) {
  const MasterSettings& master = line.master.master;
  const Duration lock_time = milliseconds(dice.between(20, 150));
  for (const SlaveNumber number : slaves) {
    const SlaveSettings& slave = master.slaves[number.value()];
    sim::DriveSettings drive;
    drive.slave.number = number;
    drive.slave.bit_rate = master.bit_rate;
    drive.slave.reference_mapping = master.process.reference_mapping;
    drive.slave.actual_mapping = slave.actual_mapping;
    drive.slave.full_length = dice.chance(500);
    drive.slave.block_limit = slave.block_limit;
    drive.slave.activate_command = master.startup.activate_command;
    drive.slave.activate_data = master.startup.activate_data;
    drive.status_parameter = slave.status_parameter;
    drive.lock_time = lock_time;
    drive.misses_until_fault = 0;
    drive.memory.size = 4096;
    drive.memory.address_step = master.command_channel.address_step;
    line.drives.push_back(drive);
  }
}

void add_faults(Dice& dice, RandomLine& line) {
  sim::Fault lost;
  lost.kind = sim::FaultKind::lost;
  lost.probability = 0.02;
  lost.identifier = 0x500;
  lost.mask = 0x700;
  line.faults.push_back(lost);
  sim::Fault destroyed;
  destroyed.kind = sim::FaultKind::corrupted;
  destroyed.probability = 0.01;
  line.faults.push_back(destroyed);
  sim::Fault edge;
  edge.kind = sim::FaultKind::missing_sync;
  edge.probability = 0.002;
  line.faults.push_back(edge);
  if (line.drives.empty() || dice.chance(500)) return;
  sim::Fault silent;
  silent.kind = sim::FaultKind::silent;
  silent.node = line.drives[dice.below(line.drives.size())].slave.number.value();
  silent.from = dice.between(300, 900);
  silent.to = silent.from + dice.between(20, 200);
  line.faults.push_back(silent);
}

}  // namespace

RandomLine random_line(std::uint64_t seed, bool faulty) {
  Dice dice(seed);
  RandomLine line;
  line.seed = seed;
  MasterSettings& master = line.master.master;
  constexpr BitRate kRates[] = {BitRate::kbit125, BitRate::kbit250, BitRate::kbit500, BitRate::mbit1};
  master.bit_rate = dice.one_of(kRates);
  master.send_margin = microseconds(slot_times(master.bit_rate).bit_time() / microseconds(1) *
                                    static_cast<std::int64_t>(dice.between(35, 60)));
  const SlaveMask slaves = random_slaves(dice);
  set_start(dice, slaves, master);
  set_process(dice, slaves, line.master);
  // One that is configured and not there: only a master that waits for nobody begins then.
  SlaveMask drives = slaves;
  if (std::popcount(slaves.bits) > 1 && master.startup.enable == EnableRule::any && dice.chance(300))
    drives.set(*slaves.begin(), false);
  add_drives(dice, drives, line);
  line.master.first_edge = microseconds(dice.below(5000));
  const std::uint64_t begin = intervals_of(milliseconds(400), master.bit_rate) + 100;
  line.intervals = static_cast<unsigned>(begin + intervals_of(milliseconds(2300), master.bit_rate) + 600);
  Routines(dice, drives, line.master).add_all(begin, line.intervals);
  if (faulty) add_faults(dice, line);
  return line;
}

}  // namespace cansync::observe::support
