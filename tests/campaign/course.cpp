#include "course.h"

#include <algorithm>
#include <utility>

#include "cansync/sim/drive_faults.h"
#include "invariants.h"

namespace cansyncd::campaign {
namespace {

constexpr std::size_t kTraceLines = 150;
/// Intervals that are still told after a violation.
constexpr std::uint64_t kAfterViolation = 3;
/// Intervals of normal operation at the end.
constexpr std::uint64_t kNormal = 20;
constexpr std::uint64_t kMemoryEvery = 16;
/// No schedule takes so many intervals and ten times those of its part with faults.
constexpr std::uint64_t kLongest = 200'000;

std::vector<std::unique_ptr<sim::Node>> drives_of(const Plan& plan) {
  std::vector<std::unique_ptr<sim::Node>> drives;
  for (const sim::DriveSettings& drive : plan.drives) drives.push_back(std::make_unique<sim::Drive>(drive));
  return drives;
}

LoopSettings loop_settings(const Plan& plan, StageBus& bus, Tamper* tamper) {
  LoopSettings settings;
  settings.sync_wire = tamper != nullptr ? static_cast<sync_line::SyncWire*>(tamper) : &bus;
  settings.target = plan.target;
  settings.wall_clock = nullptr;
  settings.look_at_every_slot = !plan.rare_looks;
  return settings;
}

can::Bus& below_loop(StageBus& bus, Tamper* tamper) {
  if (tamper == nullptr) return bus;
  tamper->attach(bus, bus);
  return *tamper;
}

}  // namespace

sim::LineSettings Course::line_settings() {
  sim::LineSettings settings;
  settings.bits_per_second = cansync::slot_times(plan_.settings.bit_rate).bits_per_second;
  settings.seed = plan_.seed;
  settings.transmit_queue = plan_.transmit_queue;
  settings.faults = plan_.faults;
  settings.protocol = &sim::drive_faults();
  settings.trace = &witness_.trace();
  return settings;
}

Course::Course(const Plan& plan, Tamper* tamper, std::function<void(const std::string&)> tell)
    : plan_(plan),
      tamper_(tamper),
      tell_(std::move(tell)),
      witness_(plan),
      recovery_(plan),
      line_(std::make_unique<sim::Line>(line_settings(), drives_of(plan))),
      exchange_(plan.sizes),
      words_(plan, exchange_, witness_.sent, verdict_.coverage, tamper),
      bus_(plan, *line_, witness_),
      loop_(tamper != nullptr ? tamper->settings(plan.settings) : plan.settings,
            loop_settings(plan, bus_, tamper), below_loop(bus_, tamper), exchange_),
      player_({plan, exchange_, *line_, witness_, ledger_, parameters_, memories_, words_, recovery_,
               verdict_.coverage, tamper, tell_}),
      scene_{plan, witness_, ledger_, parameters_, memories_, recovery_, words_} {
  witness_.follow(*line_);
  witness_.on_wait = [this](can::Time) { waits(); };
  if (tell_) {
    witness_.on_line = [this](const std::string& text) {
      if (stop_after_ != 0) tell_(text);
      trace_.push_back(text);
      if (trace_.size() > kTraceLines) trace_.pop_front();
    };
  }
  Dice dice(plan.seed ^ 0xD41FE);
  for (std::size_t i = 0; i < line_->node_count(); ++i) {
    parameters_.powered_on(drive(i));
    words_.powered_on(drive(i));
    memories_.watch(drive(i), dice);
  }
  for (unsigned i = 0; i < cansync::kSlaves; ++i) {
    scene_.mapping_before[i] = scene_.mapping_now[i] = plan.settings.slaves[i].actual_mapping;
  }
}

Course::~Course() = default;

Verdict Course::run() {
  loop_.run();
  finish();
  verdict_.digest = witness_.digest();
  verdict_.intervals = tick_;
  for (std::size_t i = 0; i < plan_.faults.size(); ++i) {
    verdict_.coverage.hit(plan_.faults[i].kind, line_->faults().hits(i));
  }
  verdict_.coverage.met(Coverage::Met::edges_skipped, scene_.skipped);
  if (plan_.stop_at != 0) verdict_.coverage.met(Coverage::Met::stopped_early);
  return verdict_;
}

// --- while it runs

void Course::waits() {
  MasterSnapshot snapshot;
  if (!exchange_.master.read(snapshot)) {
    player_.moment();
    return;
  }
  if (tamper_ != nullptr) tamper_->snapshot(snapshot);
  scene_.before = std::exchange(scene_.now, snapshot);
  interval_ended();
}

/// Edges skipped while SYNC ran: between the interval published last and the one that has an edge again.
void Course::interval_ended() {
  ++tick_;
  for (const Edge& edge : witness_.edges) {
    const bool ran = cansync::is_synchronous(scene_.before.state);
    if (ran) scene_.skipped += edge.number - scene_.before.when.interval - 1;
  }
  scene_.line_edges = line_->intervals();
  if (was_active_ && !cansync::is_active(scene_.now.state)) verdict_.coverage.met(Coverage::Met::left_active);
  was_active_ = cansync::is_active(scene_.now.state);
  look_at_values();
  player_.read();
  look_at_stops();
  look_at_drives(false);
  follow_phases();
  judge();
  for (const ActualSeen& seen : scene_.actual) scene_.counted[seen.slave.value()] = seen.report.values.count;
  witness_.forget_interval();
  player_.act(tick_, scene_.now);
  if (on_interval && !verdict_.violation) {
    if (const auto wrong = on_interval(tick_)) violated("what the caller watches", *wrong);
  }
  if (tick_ == kLongest + 10 * plan_.last_fault && !verdict_.violation) {
    violated("the schedule ends", "it does not within " + std::to_string(tick_) + " intervals");
  }
  const bool stop = stop_after_ != 0 ? tick_ >= stop_after_ : everything_over();
  if (stop) loop_.request_stop();
}

void Course::look_at_values() {
  scene_.actual.clear();
  for (const sim::DriveSettings& drive : plan_.drives) {
    ActualSeen seen{drive.slave.number, {}};
    const bool fresh = exchange_.actual[seen.slave.value()].read(seen.report);
    const bool shown = tamper_ != nullptr ? tamper_->actual(seen.report, fresh) : fresh;
    if (shown) scene_.actual.push_back(seen);
  }
  scene_.mapping_before = scene_.mapping_now;
  SettingsSnapshot settings;
  if (!exchange_.settings.read(settings)) return;
  scene_.mapping_now = settings.actual_mapping;
  player_.learn_mapping(settings.mapping_number);
}

/// In an interval with an edge in which nothing was left out, a command could go out.
void Course::look_at_stops() {
  const bool ran = cansync::is_synchronous(scene_.before.state) && cansync::is_synchronous(scene_.now.state);
  const bool left_out = scene_.now.counters.left_out != scene_.before.counters.left_out;
  witness_.stops.interval_ended(ran && !left_out && witness_.edges.size() == 1 && !player_.hangs());
}

void Course::look_at_drives(bool all) {
  const std::uint64_t now = line_->intervals();
  while (next_cycle_ < plan_.power_cycles.size() && plan_.power_cycles[next_cycle_].at <= now) {
    sim::Drive& cycled = drive(plan_.power_cycles[next_cycle_++].slave);
    cycled.restart();
    parameters_.powered_on(cycled);
    words_.powered_on(cycled);
    verdict_.coverage.met(Coverage::Met::power_cycles);
  }
  for (std::size_t i = 0; i < line_->node_count(); ++i) {
    if (!all && tick_ % line_->node_count() != i) continue;
    parameters_.look(drive(i));
    if (all || tick_ % kMemoryEvery == 0) memories_.look(drive(i), now, !plan_.disturbed(now));
  }
}

void Course::follow_phases() {
  using Phase = Recovery::Phase;
  if (plan_.stop_at != 0) return;
  if (recovery_.phase() == Phase::faults && line_->intervals() > plan_.last_fault + kLatestIntervals) {
    recovery_.faults_are_over(tick_, ledger_);
    verdict_.allowed = recovery_.allowed();
    if (tell_) tell_("nothing is provoked any more; allowed are " + std::to_string(verdict_.allowed));
  }
  recovery_.look(tick_, scene_.now, ledger_);
  if (recovery_.phase() == Phase::normal && normal_since_ == 0) {
    normal_since_ = tick_;
    verdict_.took = recovery_.took();
  }
}

bool Course::everything_over() const {
  if (plan_.stop_at != 0) return line_->intervals() >= plan_.stop_at;
  return normal_since_ != 0 && tick_ >= normal_since_ + kNormal;
}

void Course::judge() {
  if (verdict_.violation) return;
  for (const Invariant& invariant : invariants()) {
    const auto wrong = invariant.check(scene_);
    if (!wrong) continue;
    violated(invariant.name, *wrong);
    return;
  }
}

void Course::violated(const char* invariant, const std::string& what) {
  verdict_.violation = Violation{invariant, what, scene_.now.when.interval};
  stop_after_ = tick_ + kAfterViolation;
  show_trace();
}

void Course::show_trace() {
  if (!tell_) return;
  tell_("--- the frames before:");
  for (const std::string& line : trace_) tell_(line);
  tell_("*** " + verdict_.violation->invariant + ": " + verdict_.violation->what);
}

// --- the end

void Course::finish() {
  witness_.on_wait = [](can::Time) {};
  MasterSnapshot snapshot;
  if (exchange_.master.read(snapshot)) scene_.before = std::exchange(scene_.now, snapshot);
  player_.read(true);
  player_.take_back();
  words_.all_ended(line_->now());
  // What was handed to the controller before may still come; what comes later nobody has sent.
  static_cast<void>(bus_.wait_until(bus_.now() + (kLatestIntervals + 2) * plan_.interval()));
  witness_.forget_interval();
  static_cast<void>(bus_.wait_until(bus_.now() + 10 * plan_.interval()));
  look_at_drives(true);
  scene_.actual.clear();
  scene_.ended = true;
  scene_.line_edges = line_->intervals();
  judge();
  if (!verdict_.violation && !witness_.frames.empty()) {
    violated("silence_where_nothing_may_be_sent", "the master has sent something after its end");
  }
}

}  // namespace cansyncd::campaign
