// Drives that are exchanged, replaced, twice on the bus, late.
#include <algorithm>
#include <memory>
#include <utility>

#include "cansync/settings/timing.h"
#include "cansync/sim/drive_faults.h"
#include "sim/line.h"
#include "small/small_course.h"
#include "small/which_drive_plan.h"
#include "small/which_drive_truth.h"
#include "stage_bus.h"

namespace cansyncd::campaign {
namespace {

constexpr const char* kUsed = "the_drive_expected_is_used";

/// A drive that is on the bus while it is plugged in.
class PluggedDrive final : public sim::Node {
 public:
  PluggedDrive(const sim::DriveSettings& settings, std::size_t index, WhichDriveTruth& truth)
      : drive_(settings), index_(index), truth_(truth) {
    const Unit& unit = *seen().unit;
    drive_.set_parameter(sim::parameter::device_type, unit.type);
    drive_.set_parameter(sim::parameter::serial_number, unit.serial);
    drive_.answer_busy(unit.busy);
  }
  sim::NodeNumber node_number() const noexcept override { return drive_.node_number(); }
  bool accepts(const can::Frame& frame) const noexcept override { return drive_.accepts(frame); }
  void on_sync(can::Time now) noexcept override {
    if (!seen().plugged) return;
    drive_.on_sync(now);
    look();
  }
  std::optional<sim::Transmission> on_frame(const can::Frame& frame, can::Time end) noexcept override {
    if (!seen().plugged) return std::nullopt;
    const auto answer = drive_.on_frame(frame, end);
    look();
    return answer;
  }
  std::optional<sim::Transmission> on_sent(const can::Frame& frame, can::Time end) noexcept override {
    truth_.sent(index_, frame, end);
    return seen().plugged ? drive_.on_sent(frame, end) : std::nullopt;
  }

 private:
  DriveSeen& seen() const noexcept { return truth_.drives[index_]; }
  void look() noexcept { seen().synchronized = (drive_.status_word() & sim::status_bit::synchronized) != 0; }

  sim::Drive drive_;
  std::size_t index_;
  WhichDriveTruth& truth_;
};

class WhichDrivePlay final : private BusObserver {
 public:
  WhichDrivePlay(const WhichDrivePlan& plan, Tamper* tamper, const Tell& tell)
      : plan_(plan),
        tell_(tell),
        truth_(plan),
        dice_(plan.line.seed ^ 0x9AE5),
        line_(line_settings(), nodes()),
        stage_(plan.line, line_, *this),
        exchange_(plan.line.sizes),
        loop_(tamper != nullptr ? tamper->settings(plan.line.settings) : plan.line.settings,
              loop_settings(tamper), below_loop(tamper), exchange_) {
    for (const char* name : kSituations) truth_.met[name] = 0;
  }

  SmallVerdict run() {
    loop_.run();
    SmallVerdict verdict;
    verdict.digest = digest_;
    verdict.intervals = interval_;
    verdict.violation = truth_.violation();
    verdict.met = truth_.met;
    return verdict;
  }

 private:
  static constexpr const char* kSituations[] = {
      "activations",     "words_that_enable",  "words_that_enable_before_a_status_word",
      "run_begun",       "plugged_expected",   "plugged_wrong",
      "plugged_as_twin", "plugged_unexpected", "reference_values_beside_a_drive_that_is_not_expected"};

  sim::LineSettings line_settings() {
    sim::LineSettings settings;
    settings.bits_per_second = cansync::slot_times(plan_.line.settings.bit_rate).bits_per_second;
    settings.seed = plan_.line.seed;
    settings.faults = plan_.line.faults;
    settings.protocol = &sim::drive_faults();
    return settings;
  }
  std::vector<std::unique_ptr<sim::Node>> nodes() {
    std::vector<std::unique_ptr<sim::Node>> nodes;
    for (std::size_t i = 0; i < plan_.units.size(); ++i) {
      sim::DriveSettings drive;
      drive.slave.number = *cansync::SlaveNumber::from(plan_.units[i].number);
      drive.slave.bit_rate = plan_.line.settings.bit_rate;
      drive.lock_time = dice_.between(3, 40) * plan_.line.interval();
      drive.memory.size = 16;
      nodes.push_back(std::make_unique<PluggedDrive>(drive, i, truth_));
    }
    return nodes;
  }
  can::Bus& below_loop(Tamper* tamper) {
    if (tamper == nullptr) return stage_;
    tamper->attach(stage_, stage_);
    return *tamper;
  }
  LoopSettings loop_settings(Tamper* tamper) {
    LoopSettings settings;
    settings.sync_wire = tamper != nullptr ? static_cast<sync_line::SyncWire*>(tamper) : &stage_;
    settings.target = plan_.line.target;
    settings.wall_clock = nullptr;
    settings.look_at_every_slot = !plan_.line.rare_looks;
    return settings;
  }

  // what the loop does
  void waits(can::Time now) noexcept override {
    const auto interval = static_cast<std::uint64_t>(now / plan_.line.interval());
    while (interval_ < interval) begin(++interval_, now);
  }
  void edge(can::Time, can::Time) noexcept override {}
  void handed_over(const can::Frame& frame, can::Time now, can::SendResult result) noexcept override {
    if (result != can::SendResult::queued) return;
    digest_ =
        (digest_ ^ static_cast<std::uint64_t>(now.count()) ^ frame.id) * 0x100000001B3u + (digest_ >> 29);
    truth_.handed_over(frame, now);
    if (tell_) say("ours 0x", frame);
  }
  void received(const can::ReceivedFrame& received) noexcept override {
    if (received.own) return;
    truth_.received(received.frame, received.end);
    if (tell_) say("  received 0x", received.frame);
  }

  void begin(std::uint64_t interval, can::Time now) {
    for (DriveSeen& drive : truth_.drives) plug(drive, interval, now);
    Terminal terminal;
    while (exchange_.terminals.try_pop(terminal)) {
    }
    Report report;
    while (exchange_.reports.try_pop(report)) tell_event(report);
    MasterSnapshot snapshot;
    if (exchange_.master.read(snapshot)) snapshot_ = snapshot;
    give_references();
    if (interval <= plan_.end) ask(interval);
    if (truth_.violation() || over(interval, now)) loop_.request_stop();
  }

  void plug(DriveSeen& drive, std::uint64_t interval, can::Time now) {
    const Unit& unit = *drive.unit;
    const bool plugged = unit.from <= interval && interval < unit.to;
    if (plugged == drive.plugged) return;
    if (plugged) {
      ++truth_.met[drive.expected ? "plugged_expected" : "plugged_wrong"];
      for (const DriveSeen& other : truth_.drives) {
        if (other.plugged && other.unit->number == unit.number) ++truth_.met["plugged_as_twin"];
      }
      if (unit.number >= plan_.slaves()) ++truth_.met["plugged_unexpected"];
    }
    plugged ? truth_.plugged_in(drive, now) : truth_.unplugged(drive, now);
    if (tell_) {
      tell_("number " + std::to_string(unit.number) + ", serial " + std::to_string(unit.serial) +
            (plugged ? " is plugged in" : " is unplugged"));
    }
  }

  void give_references() {
    if (!cansync::is_active(snapshot_.state)) return;
    for (const auto channel : {cansync::Channel::one, cansync::Channel::two}) {
      cansync::ReferenceUpdate update;
      update.channel = channel;
      update.valid_mask = 0x0F;
      static_cast<void>(exchange_.requests.try_push(update));
    }
  }

  /// What clients and operator do.
  void ask(std::uint64_t interval) {
    const auto slave = [this] { return *cansync::SlaveNumber::from(dice_.below(plan_.slaves())); };
    if (dice_.chance(plan_.control_words)) push(cansync::ControlWordRequest{++id_, slave(), 0x000F});
    if (dice_.chance(plan_.stop_words)) push(cansync::ControlWordRequest{++id_, slave(), 0x0006});
    if (dice_.chance(plan_.parameters)) {
      cansync::ParameterRequest request;
      request.id = ++id_;
      request.slave = slave();
      request.number = *cansync::ParameterNumber::from(sim::parameter::operating_mode);
      push(request);
    }
    for (; next_mode_ < plan_.modes.size() && plan_.modes[next_mode_].first <= interval; ++next_mode_) {
      const Mode mode = plan_.modes[next_mode_].second;
      // Everything begins anew.
      for (unsigned n = 0; mode == Mode::restart && n < plan_.slaves(); ++n) truth_.released(n);
      push(ModeRequest{++id_, mode, false});
    }
    // The operator has those released that are held out: who they are is read again.
    const bool now_and_then = interval > plan_.last ? interval % 40 == 0 : dice_.chance(5);
    if (!now_and_then) return;
    release_all();
  }
  void release_all() {
    for (unsigned n = 0; n < plan_.slaves(); ++n) {
      truth_.released(n);
      push(ReleaseSlave{++id_, *cansync::SlaveNumber::from(n), false});
    }
  }
  void push(const Request& request) { static_cast<void>(exchange_.requests.try_push(request)); }

  bool over(std::uint64_t interval, can::Time now) {
    if (interval < plan_.end) return false;
    // A drive may miss two activations, each of which is repeated after 5 s.
    const can::Time patience = std::chrono::seconds(11) + 8 * plan_.line.settings.startup.status_period;
    const std::uint64_t latest = plan_.last + static_cast<std::uint64_t>(patience / plan_.line.interval());
    for (unsigned n = 0; n < plan_.slaves(); ++n) {
      const DriveSeen* const only = only_one(n);
      if (only == nullptr || !only->expected || only->synchronized) continue;
      if (interval < latest) {
        if (interval % 40 == 0) release_all();
        return false;
      }
      truth_.violated(kUsed, "slave " + std::to_string(n) + " is not", now);
    }
    return true;
  }
  const DriveSeen* only_one(unsigned number) const noexcept {
    const DriveSeen* found = nullptr;
    for (const DriveSeen& drive : truth_.drives) {
      if (!drive.plugged || drive.unit->number != number) continue;
      if (found != nullptr) return nullptr;
      found = &drive;
    }
    return found;
  }

  void say(const char* what, const can::Frame& frame) {
    char text[80];
    std::snprintf(text, sizeof text, "%llu us: %s%03X#",
                  static_cast<unsigned long long>(line_.now().count() / 1000), what, frame.id);
    std::string line = text;
    for (unsigned i = 0; i < frame.dlc; ++i) {
      std::snprintf(text, sizeof text, "%02X", frame.data[i]);
      line += text;
    }
    tell_(line);
  }
  void tell_event(const Report& report) {
    const auto* event = std::get_if<EventReport>(&report);
    if (event == nullptr || !tell_) return;
    tell_("event " + std::string(name(event->event.code)) +
          (event->event.slave ? " of slave " + std::to_string(event->event.slave->value()) : std::string()));
  }

  const WhichDrivePlan& plan_;
  const Tell& tell_;
  WhichDriveTruth truth_;
  Dice dice_;
  sim::Line line_;
  StageBus stage_;
  Exchange exchange_;
  RealtimeLoop loop_;
  MasterSnapshot snapshot_;
  std::uint64_t interval_ = 0;
  std::uint64_t digest_ = 0xCBF29CE484222325u;
  std::size_t next_mode_ = 0;
  cansync::JobId id_ = 0;
};

SmallVerdict play_which_drive(std::uint64_t seed, Tamper* tamper, const Tell& tell) {
  const WhichDrivePlan plan = draw_which_drive(seed);
  if (tell) tell(describe(plan));
  return WhichDrivePlay(plan, tamper, tell).run();
}

constexpr const char* kWhichDriveInvariants[] = {
    "nothing_is_released_to_a_drive_that_is_not_the_one_expected",
    "no_word_that_enables_to_a_drive_that_is_not_the_one_expected",
    "nothing_begins_with_two_drives_of_one_number", kUsed};

}  // namespace

const SmallCourse kWhichDriveCourse = {"which_drive", kWhichDriveInvariants, &play_which_drive};

}  // namespace cansyncd::campaign
