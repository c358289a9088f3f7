#include "small/which_drive_plan.h"

#include <algorithm>
#include <bit>
#include <limits>
#include <sstream>

#include "cansync/settings/timing.h"

namespace cansyncd::campaign {
namespace {

using cansync::ParameterNumber;

constexpr std::uint32_t kType = 4400;
constexpr std::uint32_t kSerial = 1000;
constexpr std::uint64_t kStays = std::numeric_limits<std::uint64_t>::max();
constexpr std::uint64_t kEvents = 400;  ///< intervals in which something is provoked

void draw_settings(Dice& dice, WhichDrivePlan& plan) {
  cansync::MasterSettings& settings = plan.line.settings;
  // An interval of 8 ms makes few of the 5 s after which a drive is activated again.
  settings.bit_rate = dice.chance(950) ? cansync::BitRate::kbit125 : cansync::BitRate::kbit250;
  settings.send_margin = cansync::default_send_margin(settings.bit_rate);
  const can::Time interval = plan.line.interval();
  settings.startup.enable = static_cast<cansync::EnableRule>(dice.below(3));
  settings.startup.status_period = dice.between(3, 125) * interval;
  settings.startup.lost_after = static_cast<std::uint8_t>(dice.between(1, 4));
  settings.startup.census = dice.chance(300);
  settings.command_channel.minimum_share = static_cast<std::uint32_t>(dice.between(2, 10));
  const auto slaves = static_cast<unsigned>(dice.between(1, 3));
  settings.process.maximum_slave = *cansync::SlaveNumber::from(slaves - 1);
  const bool type_first = dice.chance(500);
  for (unsigned n = 0; n < slaves; ++n) {
    cansync::SlaveSettings& slave = settings.slaves[n];
    slave.configured = true;
    if (n != 0 && dice.chance(150)) continue;  // any drive
    const cansync::ParameterValue type{*ParameterNumber::from(sim::parameter::device_type), kType};
    const cansync::ParameterValue serial{*ParameterNumber::from(sim::parameter::serial_number), kSerial + n};
    const bool type_alone = dice.chance(100);
    if (type_alone || type_first) slave.expect[slave.expect_count++] = type;
    if (!type_alone) slave.expect[slave.expect_count++] = serial;
    if (!type_alone && !type_first) slave.expect[slave.expect_count++] = type;
  }
  plan.line.target = dice.chance(700) ? StartTarget::active : StartTarget::setup;
  plan.line.rare_looks = dice.chance(500);
}

std::uint64_t draw_absence(Dice& dice) {
  return kShortestAbsence + (dice.chance(600) ? dice.below(40) : dice.below(300));
}

Unit unit_of(unsigned number, std::uint32_t serial, std::uint64_t from) {
  return {number, kType, serial, from, kStays, 0};
}

/// The drives of one number, one after the other.
void draw_place(Dice& dice, WhichDrivePlan& plan, unsigned number) {
  std::uint64_t at = dice.chance(700) ? 0 : dice.below(kEvents);
  Unit unit = unit_of(number, dice.chance(850) ? kSerial + number : kSerial + 100, at);
  for (std::uint64_t changes = dice.below(3); changes > 0; --changes) {
    unit.to = at + 1 + dice.below(kEvents);
    plan.units.push_back(unit);
    at = unit.to + draw_absence(dice);
    unit = unit_of(number, kSerial + number, at);
    if (dice.chance(400)) unit.serial = kSerial + 100 + static_cast<std::uint32_t>(dice.below(3));
    if (dice.chance(200)) unit.type = kType + 1;
    if (dice.chance(200)) unit.busy = static_cast<std::uint32_t>(dice.below(6));
  }
  plan.units.push_back(unit);
}

/// The drives of two numbers are exchanged.
void draw_exchange(Dice& dice, WhichDrivePlan& plan) {
  const std::uint64_t at = 1 + dice.below(kEvents);
  const std::uint64_t back = at + draw_absence(dice);
  for (const unsigned number : {0u, 1u}) {
    const unsigned other = 1 - number;
    std::erase_if(plan.units, [&](const Unit& unit) { return unit.number == number; });
    Unit before = unit_of(number, kSerial + number, 0);
    before.to = at;
    plan.units.push_back(before);
    plan.units.push_back(unit_of(number, kSerial + other, back + dice.below(10)));
    // And back again.
    if (!dice.chance(300)) continue;
    plan.units.back().to = back + 200;
    plan.units.push_back(unit_of(number, kSerial + number, back + 200 + draw_absence(dice)));
  }
}

/// A second drive of a number, or one of a number that is not configured.
void draw_strangers(Dice& dice, WhichDrivePlan& plan) {
  const auto number = static_cast<unsigned>(dice.below(plan.slaves()));
  if (dice.chance(200)) {
    Unit twin = unit_of(number, dice.chance(300) ? kSerial + number : kSerial + 50, dice.below(kEvents));
    if (dice.chance(300)) twin.to = twin.from + 50 + dice.below(300);
    plan.units.push_back(twin);
  }
  if (dice.chance(150)) plan.units.push_back(unit_of(9, kSerial + 9, dice.below(kEvents)));
}

void draw_faults(Dice& dice, WhichDrivePlan& plan) {
  constexpr double kLost[] = {0.01, 0.05, 0.1};
  const auto number = [&] { return static_cast<sim::NodeNumber>(dice.below(plan.slaves())); };
  if (dice.chance(300)) {
    plan.line.faults.push_back(
        {.kind = sim::FaultKind::lost, .from = 0, .to = kEvents, .probability = dice.one_of(kLost)});
  }
  if (dice.chance(300)) {
    const std::uint64_t from = dice.below(kEvents);
    sim::Fault fault{.kind = sim::FaultKind::silent, .from = from, .to = from + dice.below(100)};
    fault.node = number();
    plan.line.faults.push_back(fault);
  }
  if (dice.chance(300)) {
    const std::uint64_t from = dice.below(kEvents);
    sim::Fault fault{.kind = sim::FaultKind::missing_sync, .from = from, .to = from + dice.below(40)};
    if (dice.chance(500)) fault.node = number();
    plan.line.faults.push_back(fault);
  }
  if (dice.chance(150)) plan.line.lateness.push_back({{0, kEvents}, 10, 3 * plan.line.interval()});
}

}  // namespace

unsigned WhichDrivePlan::slaves() const noexcept {
  return static_cast<unsigned>(std::popcount(line.settings.configured().bits));
}

bool WhichDrivePlan::expected(const Unit& unit) const noexcept {
  const auto list = cansync::expected_of(line.settings.slaves[unit.number]);
  return std::all_of(list.begin(), list.end(), [&](const cansync::ParameterValue& wanted) {
    const bool is_type = wanted.number.value() == sim::parameter::device_type;
    return wanted.value == (is_type ? unit.type : unit.serial);
  });
}

WhichDrivePlan draw_which_drive(std::uint64_t seed) {
  constexpr Mode kModes[] = {Mode::set_up, Mode::run, Mode::restart};
  constexpr unsigned kOften[] = {0, 20, 200};
  Dice dice(seed ^ 0xD217E);
  WhichDrivePlan plan;
  plan.line.seed = seed;
  draw_settings(dice, plan);
  for (unsigned n = 0; n < plan.slaves(); ++n) draw_place(dice, plan, n);
  if (plan.slaves() > 1 && dice.chance(300)) draw_exchange(dice, plan);
  draw_strangers(dice, plan);
  draw_faults(dice, plan);
  for (std::uint64_t i = dice.chance(300) ? dice.between(1, 3) : 0; i > 0; --i)
    plan.modes.emplace_back(dice.below(kEvents), dice.one_of(kModes));
  std::sort(plan.modes.begin(), plan.modes.end());
  plan.control_words = 20 + dice.one_of(kOften);
  plan.stop_words = dice.one_of(kOften) / 2;
  plan.parameters = 4 * dice.one_of(kOften);
  plan.last = kEvents;
  for (const Unit& unit : plan.units)
    plan.last = std::max({plan.last, unit.from, unit.to == kStays ? 0 : unit.to});
  for (const sim::Fault& fault : plan.line.faults) plan.last = std::max(plan.last, fault.to);
  // Every other one until a drive that does not synchronize is activated again.
  plan.end = plan.last +
             static_cast<std::uint64_t>(dice.chance(500) ? 20 : 5'200'000'000 / plan.line.interval().count());
  return plan;
}

std::string describe(const WhichDrivePlan& plan) {
  const cansync::MasterSettings& settings = plan.line.settings;
  std::ostringstream out;
  out << "seed " << plan.line.seed << ", " << plan.slaves() << " slaves, enable rule "
      << static_cast<int>(settings.startup.enable) << ", status period "
      << settings.startup.status_period / plan.line.interval() << " intervals, lost after "
      << +settings.startup.lost_after << ", minimum share " << settings.command_channel.minimum_share
      << ", target " << static_cast<int>(plan.line.target) << ", last " << plan.last << ", end " << plan.end
      << "\n";
  for (unsigned n = 0; n < plan.slaves(); ++n) {
    out << "slave " << n << " is expected to have";
    for (const auto& wanted : cansync::expected_of(settings.slaves[n]))
      out << " " << wanted.number.value() << "=" << wanted.value;
    out << "\n";
  }
  for (const Unit& unit : plan.units) {
    out << "drive of number " << unit.number << ", type " << unit.type << ", serial " << unit.serial
        << (plan.expected(unit) ? ", expected" : ", WRONG") << ", from " << unit.from;
    if (unit.to != kStays) out << " to " << unit.to;
    if (unit.busy != 0) out << ", busy " << unit.busy;
    out << "\n";
  }
  for (const sim::Fault& fault : plan.line.faults) {
    out << "fault: " << name(fault.kind) << " in " << fault.from << ".." << fault.to << ", probability "
        << fault.probability;
    if (fault.node) out << ", slave " << +*fault.node;
    out << "\n";
  }
  for (const auto& [at, mode] : plan.modes) out << "mode " << static_cast<int>(mode) << " in " << at << "\n";
  out << "in a thousand intervals: control words " << plan.control_words << ", that stop " << plan.stop_words
      << ", parameters " << plan.parameters << "\n";
  return out.str();
}

}  // namespace cansyncd::campaign
