// Another master on the bus, whatever the instant it comes or we start.
#include <algorithm>
#include <memory>
#include <utility>

#include "can/passing_bus.h"
#include "cansync/settings/timing.h"
#include "cansync/telegram/telegram.h"
#include "daemon/loop/sync_line.h"
#include "sim/line.h"
#include "small/other_master_plan.h"
#include "small/other_master_truth.h"
#include "small/small_course.h"
#include "stage_bus.h"

namespace cansyncd::campaign {
namespace {

constexpr const char* kBegins = "it_begins_when_the_other_master_has_gone";
constexpr sim::NodeNumber kOtherNumber = 31;  ///< by which the trace knows the other master

/// Another master: sends what the plan says, and hears nothing.
class OtherMaster final : public sim::Node {
 public:
  explicit OtherMaster(const OtherMasterPlan& plan) : plan_(plan) {}
  sim::NodeNumber node_number() const noexcept override { return kOtherNumber; }
  bool accepts(const can::Frame&) const noexcept override { return false; }
  void on_sync(can::Time) noexcept override {}
  std::optional<sim::Transmission> on_frame(const can::Frame&, can::Time) noexcept override {
    return std::nullopt;
  }
  std::optional<can::Time> next_time() const noexcept override {
    return next_ < plan_.others.size() ? plan_.others[next_].first : can::Time::max();
  }
  sim::Deed on_time(can::Time now) noexcept override {
    return {false, sim::Transmission{plan_.others[next_++].second, now}};
  }

 private:
  const OtherMasterPlan& plan_;
  std::size_t next_ = 0;
};

bool is_from_a_master(const can::Frame& frame, bool sync_frames) noexcept {
  if (sync_frames && frame.id == kSyncIdentifier && frame.dlc == 0) return true;
  return frame.id == 0x010 || (frame.id >= 0x100 && frame.id <= 0x1FF) ||
         (frame.id >= 0x500 && frame.id <= 0x57F);
}

/// The bus as the daemon has it: nothing passes while it is cut off.
class CutBus final : public can::PassingBus, public sync_line::SyncWire {
 public:
  CutBus(const OtherMasterPlan& plan, StageBus& stage, Outages& outages, OtherMasterTruth& truth)
      : PassingBus(stage), plan_(plan), stage_(stage), outages_(outages), truth_(truth) {}

  /// Called whenever the loop comes by.
  std::function<void(can::Time)> on_call = [](can::Time) {};
  std::function<void(const std::string&)> on_act;

  can::Wake wait_until(can::Time deadline) noexcept override {
    on_call(now());
    return stage_.wait_until(deadline);
  }
  bool receive(can::ReceivedFrame& out) noexcept override {
    while (stage_.receive(out)) {
      if (outages_.at(out.end) != nullptr) continue;
      if (!out.own && is_from_a_master(out.frame, plan_.sync_frames)) truth_.taken();
      return true;
    }
    return false;
  }
  can::SendResult send(const can::Frame& frame) noexcept override {
    on_call(now());
    if (const Outages::Gap* gap = outages_.at(now())) {
      if (gap->outage.kind == Outage::Kind::bus_off) return can::SendResult::bus_off;
      return gap->outage.kind == Outage::Kind::cable_off ? can::SendResult::not_delivered
                                                         : can::SendResult::interface_down;
    }
    const can::SendResult result = stage_.send(frame);
    if (result == can::SendResult::queued) {
      const bool reference = (frame.id & 0x700u) == cansync::identifier::reference_one;
      const bool of_edge = frame.id == kSyncIdentifier && truth_.last_edge() == now();
      if (!of_edge) truth_.telegram(reference, now());
      act(frame.id);
    }
    return result;
  }
  void sync_edge(can::Time due) noexcept override {
    on_call(now());
    stage_.sync_edge(due);
    truth_.edge(now());
    act(0);
  }
  can::ControllerStatus status() noexcept override {
    outages_.looked(now());
    can::ControllerStatus status = stage_.status();
    for (const Outage& outage : plan_.outages) {
      if (outage.kind == Outage::Kind::bus_off && outage.to <= now()) ++status.restarts;
    }
    if (const Outages::Gap* gap = outages_.at(now())) {
      if (gap->outage.kind == Outage::Kind::bus_off) status.state = can::ControllerState::bus_off;
      if (gap->outage.kind == Outage::Kind::interface_down) status.link = can::LinkState::down;
      if (gap->outage.kind == Outage::Kind::cable_off) status.delivery = can::Delivery::unacknowledged;
    }
    return status;
  }

  std::uint64_t digest() const noexcept { return digest_; }

 private:
  void act(std::uint32_t identifier) {
    digest_ =
        (digest_ ^ static_cast<std::uint64_t>(now().count()) ^ identifier) * 0x100000001B3u + (digest_ >> 29);
    if (on_act)
      on_act(identifier == 0 ? "SYNC edge" : "telegram of ours, identifier " + std::to_string(identifier));
  }

  const OtherMasterPlan& plan_;
  StageBus& stage_;
  Outages& outages_;
  OtherMasterTruth& truth_;
  std::uint64_t digest_ = 0xCBF29CE484222325u;
};

class NobodyWatches final : public BusObserver {
  void waits(can::Time) noexcept override {}
  void edge(can::Time, can::Time) noexcept override {}
  void handed_over(const can::Frame&, can::Time, can::SendResult) noexcept override {}
  void received(const can::ReceivedFrame&) noexcept override {}
};

class OtherMasterPlay final : private sim::TraceSink {
 public:
  OtherMasterPlay(const OtherMasterPlan& plan, Tamper* tamper, const Tell& tell)
      : plan_(plan),
        tell_(tell),
        outages_(plan.outages),
        truth_(plan, outages_),
        line_(line_settings(), nodes()),
        stage_(plan.line, line_, nobody_),
        bus_(plan, stage_, outages_, truth_),
        sync_(sync_config(), plan.line.interval(), sync_line::kernel()),
        exchange_(plan.line.sizes),
        loop_(tamper != nullptr ? tamper->settings(plan.line.settings) : plan.line.settings,
              loop_settings(tamper), below_loop(tamper), exchange_) {
    for (const char* name : kSituations) truth_.met[name] = 0;
    bus_.on_call = [this](can::Time now) { called(now); };
    if (!tell_) return;
    bus_.on_act = [this](const std::string& what) { say(what); };
  }

  SmallVerdict run() {
    loop_.run();
    SmallVerdict verdict;
    verdict.digest = bus_.digest();
    verdict.intervals = static_cast<std::uint64_t>(line_.now() / plan_.line.interval());
    verdict.violation = truth_.violation();
    verdict.met = truth_.met;
    return verdict;
  }

 private:
  static constexpr const char* kSituations[] = {"came_before_our_first_frame",
                                                "came_while_SYNC_ran",
                                                "came_in_run",
                                                "came_after_bus_off",
                                                "came_after_the_interface_was_down",
                                                "came_after_the_cable_was_off",
                                                "began_when_the_other_had_gone",
                                                "begun_by_a_command",
                                                "sent_by_force"};

  sim::LineSettings line_settings() {
    sim::LineSettings settings;
    settings.bits_per_second = cansync::slot_times(plan_.line.settings.bit_rate).bits_per_second;
    settings.seed = plan_.line.seed;
    settings.trace = this;
    return settings;
  }
  std::vector<std::unique_ptr<sim::Node>> nodes() {
    std::vector<std::unique_ptr<sim::Node>> nodes;
    nodes.push_back(std::make_unique<OtherMaster>(plan_));
    for (const sim::DriveSettings& drive : plan_.line.drives)
      nodes.push_back(std::make_unique<sim::Drive>(drive));
    return nodes;
  }
  DaemonConfig sync_config() const {
    DaemonConfig config;
    config.bus.bits_per_second = cansync::slot_times(plan_.line.settings.bit_rate).bits_per_second;
    config.sync.output = plan_.sync_frames ? SyncOutput::can : SyncOutput::none;
    config.sync.can_identifier = kSyncIdentifier;
    return config;
  }
  can::Bus& below_loop(Tamper* tamper) {
    if (tamper == nullptr) return bus_;
    tamper->attach(bus_, bus_);
    return *tamper;
  }
  LoopSettings loop_settings(Tamper* tamper) {
    LoopSettings settings;
    settings.sync_wire = tamper != nullptr ? static_cast<sync_line::SyncWire*>(tamper) : &bus_;
    settings.sync_line = &sync_;
    settings.target = plan_.line.target;
    settings.wall_clock = nullptr;
    settings.look_at_every_slot = !plan_.line.rare_looks;
    settings.after_other_master = tamper != nullptr ? tamper->after_other_master(plan_.after) : plan_.after;
    return settings;
  }

  void frame(const sim::TracedFrame& traced) noexcept override {
    if (traced.sender.kind != sim::Sender::Kind::node || traced.sender.node != kOtherNumber) return;
    truth_.other_sent(traced.end);
    if (tell_) say("frame of the other master until " + std::to_string(traced.end.count() / 1000) + " us");
  }
  void sync(can::Time) noexcept override {}

  void called(can::Time now) {
    truth_.hear(now);
    Terminal terminal;
    while (exchange_.terminals.try_pop(terminal)) answered(terminal, now);
    Report report;
    while (exchange_.reports.try_pop(report)) {
    }
    while (next_order_ < plan_.orders.size() && plan_.orders[next_order_].at <= now)
      give(plan_.orders[next_order_++], now);
    give_references(now);
    if (truth_.violation() || over(now)) loop_.request_stop();
  }
  void give(const Order& order, can::Time now) {
    given_.push_back(order);
    truth_.ordered(order, now);
    if (tell_)
      say("order: mode " + std::to_string(static_cast<int>(order.mode)) + (order.force ? " by force" : ""));
    static_cast<void>(exchange_.requests.try_push(ModeRequest{given_.size(), order.mode, order.force}));
  }
  void answered(const Terminal& terminal, can::Time now) {
    const auto* done = std::get_if<CommandDone>(&terminal);
    if (tell_) say(done != nullptr ? "order obeyed" : "order refused");
    if (done != nullptr) truth_.obeyed(given_[done->id - 1], now);
  }
  /// In run each of them is good for a second or more.
  void give_references(can::Time now) {
    MasterSnapshot snapshot;
    if (!exchange_.master.read(snapshot)) return;
    if (!cansync::is_active(snapshot.state)) {
      references_until_ = can::Time{0};
      return;
    }
    if (now < references_until_) return;
    cansync::ReferenceUpdate update;
    update.valid_mask = 1;
    update.release_intervals = 100;
    static_cast<void>(exchange_.requests.try_push(update));
    references_until_ = now + 90 * plan_.line.interval();
  }

  /// When nothing is provoked any more the line comes back, where a command is needed with one.
  bool over(can::Time now) {
    const can::Time interval = plan_.line.interval();
    const can::Time listen = plan_.line.settings.startup.listen;
    if (now <= plan_.last + 5 * interval) return false;
    // The daemon has to hear nothing for so long: it hears nothing in an interval that its thread missed, or while
    // it is cut off.
    can::Time deaf{0};
    for (const Outage& outage : plan_.outages) deaf += outage.to - outage.from + interval;
    const can::Time begins =
        std::max(plan_.last + listen, truth_.last_other() + std::chrono::seconds(3) + deaf);
    const can::Time missed = plan_.line.lateness.empty() ? can::Time{0} : 3 * begins;
    const can::Time latest = begins + 50 * interval + missed;
    if (truth_.last_edge() > last_edge_) ++edges_;
    last_edge_ = truth_.last_edge();
    if (edges_ > 10) return true;
    if (now > latest) {
      truth_.violated(kBegins, "there is no SYNC, though nobody else is there", now);
      return true;
    }
    if (needs_operator() && now > begins + interval && now > last_edge_ + 3 * interval &&
        now > ordered_again_ + 10 * interval) {
      ordered_again_ = now;
      give(Order{now, Mode::set_up, false}, now);
    }
    return false;
  }
  bool needs_operator() const {
    return plan_.after == AfterOtherMaster::command ||
           std::any_of(plan_.orders.begin(), plan_.orders.end(),
                       [](const Order& order) { return order.mode == Mode::stop; });
  }

  void say(const std::string& what) { tell_(std::to_string(line_.now().count() / 1000) + " us: " + what); }

  const OtherMasterPlan& plan_;
  const Tell& tell_;
  Outages outages_;
  OtherMasterTruth truth_;
  sim::Line line_;
  NobodyWatches nobody_;
  StageBus stage_;
  CutBus bus_;
  SyncLine sync_;
  Exchange exchange_;
  RealtimeLoop loop_;
  std::size_t next_order_ = 0;
  std::vector<Order> given_;
  can::Time references_until_{0};
  can::Time last_edge_{0};
  unsigned edges_ = 0;  ///< since nothing is provoked any more
  can::Time ordered_again_{0};
};

SmallVerdict play(std::uint64_t seed, Tamper* tamper, const Tell& tell) {
  const OtherMasterPlan plan = draw_other_master(seed);
  if (tell) tell(describe(plan));
  return OtherMasterPlay(plan, tamper, tell).run();
}

constexpr const char* kInvariants[] = {"it_listens_before_its_first_frame",
                                       "no_frame_of_ours_while_another_master_is_there",
                                       "after_another_master_it_waits_for_the_command", kBegins};

}  // namespace

const SmallCourse kOtherMasterCourse = {"other_master", kInvariants, &play};

}  // namespace cansyncd::campaign
