#include "small/other_master_plan.h"

#include <algorithm>
#include <sstream>

#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"
#include "sync/software_sync.h"

namespace cansyncd::campaign {
namespace {

using std::chrono::milliseconds;

can::Time draw_time(Dice& dice, can::Time from, can::Time to) {
  return can::Time(
      dice.between(static_cast<std::uint64_t>(from.count()), static_cast<std::uint64_t>(to.count())));
}

void draw_line(Dice& dice, OtherMasterPlan& plan) {
  using cansync::BitRate;
  // An interval of 8 ms makes few of 3 s.
  constexpr BitRate kRates[] = {BitRate::kbit125, BitRate::kbit125, BitRate::kbit125, BitRate::kbit125,
                                BitRate::kbit125, BitRate::kbit125, BitRate::kbit125, BitRate::kbit250};
  Plan& line = plan.line;
  cansync::MasterSettings& settings = line.settings;
  settings.bit_rate = dice.chance(10) ? BitRate::mbit1 : dice.one_of(kRates);
  settings.send_margin = cansync::default_send_margin(settings.bit_rate);
  settings.slaves[0].configured = true;
  settings.startup.enable =
      dice.chance(500) ? cansync::EnableRule::any : cansync::EnableRule::all_synchronized;
  settings.startup.listen =
      draw_time(dice, line.interval(), dice.chance(500) ? milliseconds(100) : milliseconds(1000));
  line.target = dice.chance(500) ? StartTarget::active : StartTarget::setup;
  const bool stops = line.target == StartTarget::active || dice.chance(500);
  settings.startup.on_second_master = stops ? cansync::OnSecondMaster::stop : cansync::OnSecondMaster::report;
  line.rare_looks = dice.chance(500);
  plan.after = dice.chance(250) ? AfterOtherMaster::command : AfterOtherMaster::resume;
  plan.sync_frames = dice.chance(300);
  sim::DriveSettings drive;
  drive.slave.bit_rate = settings.bit_rate;
  drive.lock_time = dice.between(3, 20) * line.interval();
  drive.memory.size = 16;
  line.drives.push_back(drive);
  if (!dice.chance(200)) return;
  const can::Time most = dice.chance(500) ? line.interval() / 4 : 10 * line.interval();
  line.lateness.push_back({{0, 300}, dice.chance(500) ? 10u : 50u, most});
}

/// What only a master sends; its identifier tells it, whatever stands in the frame.
can::Frame draw_master_frame(Dice& dice, bool sync_frames) {
  if (sync_frames && dice.chance(400)) return sync_line::software_sync(kSyncIdentifier);
  can::Frame frame;
  switch (dice.below(5)) {
    case 0:
      frame = encode(cansync::ActionCommand{cansync::SlaveMask::all(), 200, 0, 0});
      break;
    case 1:
      frame = encode(cansync::ParameterCommand{});
      break;
    default: {
      cansync::ReferenceTelegram telegram;
      telegram.channel = dice.chance(500) ? cansync::Channel::one : cansync::Channel::two;
      if (dice.chance(300)) telegram.polled = static_cast<std::uint8_t>(dice.below(128));
      frame = encode(telegram);
      break;
    }
  }
  if (dice.chance(50)) frame.dlc = static_cast<std::uint8_t>(dice.below(9));
  return frame;
}

/// One presence of another master: as a rule in each interval, or rarely, or a single frame.
void draw_presence(Dice& dice, OtherMasterPlan& plan, can::Time latest) {
  const can::Time interval = plan.line.interval();
  can::Time from = dice.chance(200) ? can::Time{0} : draw_time(dice, can::Time{0}, latest);
  // Also when the bus comes back.
  if (!plan.outages.empty() && dice.chance(400)) {
    from = plan.outages.back().to + draw_time(dice, can::Time{0}, plan.line.settings.startup.listen);
    if (dice.chance(300)) from -= std::min(from, can::Time(milliseconds(200)));
  }
  const can::Time length =
      dice.chance(300) ? can::Time{0} : draw_time(dice, can::Time{0}, milliseconds(1500));
  can::Time period = interval + can::Time(dice.below(100'000)) - can::Time(50'000);
  if (dice.chance(300)) period = draw_time(dice, interval, milliseconds(2900));
  const bool same = dice.chance(700);
  can::Frame frame = draw_master_frame(dice, plan.sync_frames);
  for (can::Time at = from; at <= from + length; at += period) {
    plan.others.emplace_back(at, frame);
    if (!same) frame = draw_master_frame(dice, plan.sync_frames);
  }
}

void draw_outages(Dice& dice, OtherMasterPlan& plan, can::Time latest) {
  constexpr Outage::Kind kKinds[] = {Outage::Kind::bus_off, Outage::Kind::interface_down,
                                     Outage::Kind::cable_off};
  can::Time from{0};
  for (std::uint64_t i = dice.chance(500) ? dice.between(1, 2) : 0; i > 0; --i) {
    Outage outage;
    outage.kind = dice.one_of(kKinds);
    // The bus may be missing from the start.
    outage.from = from + (dice.chance(100) ? can::Time{0} : draw_time(dice, can::Time{0}, latest));
    // The controller's restarts are counted; of anything else a daemon sees what lasts from look to look.
    const can::Time shortest =
        outage.kind == Outage::Kind::bus_off ? can::Time(milliseconds(1)) : 15 * plan.line.interval();
    outage.to = outage.from + shortest +
                draw_time(dice, can::Time{0}, dice.chance(500) ? milliseconds(50) : milliseconds(1000));
    from = outage.to + 20 * plan.line.interval();
    plan.outages.push_back(outage);
  }
}

void draw_orders(Dice& dice, OtherMasterPlan& plan, can::Time latest) {
  constexpr Mode kModes[] = {Mode::set_up, Mode::set_up, Mode::run, Mode::stop, Mode::restart};
  for (std::uint64_t i = dice.chance(400) ? dice.between(1, 3) : 0; i > 0; --i) {
    Order order;
    order.at = draw_time(dice, can::Time{0}, latest);
    order.mode = dice.one_of(kModes);
    // In run, another master that is only reported may be there.
    if (order.mode == Mode::run &&
        plan.line.settings.startup.on_second_master == cansync::OnSecondMaster::report)
      order.mode = Mode::set_up;
    order.force = order.mode == Mode::set_up && dice.chance(300);
    plan.orders.push_back(order);
  }
}

}  // namespace

OtherMasterPlan draw_other_master(std::uint64_t seed) {
  Dice dice(seed ^ 0x07E4);
  OtherMasterPlan plan;
  plan.line.seed = seed;
  draw_line(dice, plan);
  const can::Time latest = plan.line.settings.startup.listen + milliseconds(1200);
  draw_outages(dice, plan, latest);
  for (std::uint64_t i = dice.chance(800) ? 1 : 2; i > 0; --i) draw_presence(dice, plan, latest);
  draw_orders(dice, plan, latest + milliseconds(1000));
  const auto earlier = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::stable_sort(plan.others.begin(), plan.others.end(), earlier);
  std::stable_sort(plan.orders.begin(), plan.orders.end(),
                   [](const Order& a, const Order& b) { return a.at < b.at; });
  for (const auto& [at, frame] : plan.others) plan.last = std::max(plan.last, at);
  for (const Outage& outage : plan.outages) plan.last = std::max(plan.last, outage.to);
  for (const Order& order : plan.orders) plan.last = std::max(plan.last, order.at);
  return plan;
}

std::string describe(const OtherMasterPlan& plan) {
  constexpr const char* kKinds[] = {"bus-off", "interface down", "cable off"};
  const auto ms = [](can::Time time) { return static_cast<double>(time.count()) / 1e6; };
  const cansync::MasterSettings& settings = plan.line.settings;
  std::ostringstream out;
  out << "seed " << plan.line.seed << ", interval " << ms(plan.line.interval()) << " ms, listens "
      << ms(settings.startup.listen) << " ms, target " << static_cast<int>(plan.line.target)
      << (settings.startup.on_second_master == cansync::OnSecondMaster::stop ? ", stops" : ", reports")
      << " in run, " << (plan.after == AfterOtherMaster::command ? "waits for a command" : "resumes")
      << ", SYNC " << (plan.sync_frames ? "frames" : "wire") << ", "
      << (plan.line.rare_looks ? "woken by slots" : "woken by frames") << ", thread "
      << (plan.line.lateness.empty() ? "punctual" : "late") << "\n";
  for (const auto& [at, frame] : plan.others) {
    out << "other master: " << ms(at) << " ms, identifier 0x" << std::hex << frame.id << std::dec << "\n";
  }
  for (const Outage& outage : plan.outages) {
    out << kKinds[static_cast<unsigned>(outage.kind)] << ": " << ms(outage.from) << ".." << ms(outage.to)
        << " ms\n";
  }
  for (const Order& order : plan.orders) {
    out << "order: " << ms(order.at) << " ms, mode " << static_cast<int>(order.mode)
        << (order.force ? " by force" : "") << "\n";
  }
  return out.str();
}

}  // namespace cansyncd::campaign
