// The gateway's side: pushing, reading, and what the operator does.
#include "player.h"

#include <algorithm>
#include <span>
#include <utility>
#include <variant>

namespace cansyncd::campaign {

using cansync::Channel;
using cansync::SlaveNumber;

namespace {

/// Intervals an operator gives the controller to come back.
constexpr std::uint64_t kResetTime = 5;
/// Most intervals in which the gateway hangs, altogether.
constexpr std::uint64_t kLongestHang = 500;

}  // namespace

Player::Player(const Stage& stage) : stage_(stage), dice_(stage.plan.seed ^ 0x9147E4) {
  if (stage.plan.writers.strengths.empty()) return;
  writers_ = std::make_unique<Writers>(stage.plan, stage.exchange, stage.line, stage.witness.references,
                                       stage.tamper);
  writers_->on_event = stage.tell;
  stage.witness.references.set_hold(stage.plan.writers.hold);
  stage.witness.references.set_limits(stage.plan.settings.process.reference_limits);
  stage.witness.references.set_maximum_age(stage.plan.writers.maximum_age);
}

bool Player::hangs() const noexcept {
  const auto& hangs = stage_.plan.hangs;
  const std::uint64_t now = stage_.line.intervals();
  // A stopped line counts no edges: a gateway that hung until the next one would hang for ever.
  return !over() && hung_ < kLongestHang &&
         std::any_of(hangs.begin(), hangs.end(), [now](const Window& w) { return w.has(now); });
}

bool Player::push(const Request& request, const Job* job, const std::string& text) {
  const bool pushed = stage_.exchange.requests.try_push(request);
  if (!pushed) stage_.coverage.met(Coverage::Met::ring_full);
  if (pushed && job != nullptr) {
    stage_.ledger.opened(*job);
    stage_.words.pushed(job->id, request);
  }
  if (stage_.tell) {
    const std::string id = job != nullptr ? "request " + std::to_string(job->id) + ": " : "";
    stage_.tell(id + text + (pushed ? "" : " (no room)"));
  }
  return pushed;
}

sim::Drive* Player::drive_of(SlaveNumber slave) {
  for (std::size_t i = 0; i < stage_.line.node_count(); ++i) {
    auto* drive = dynamic_cast<sim::Drive*>(&stage_.line.node(i));
    if (drive != nullptr && drive->number() == slave) return drive;
  }
  return nullptr;
}

// --- answers

void Player::read(bool whatever_happens) {
  if (!whatever_happens && hangs()) {
    ++hung_;
    stage_.coverage.met(Coverage::Met::gateway_hung);
    return;
  }
  popped_.clear();
  Terminal terminal;
  while (stage_.exchange.terminals.try_pop(terminal)) popped_.push_back(terminal);
  if (stage_.tamper != nullptr) stage_.tamper->terminals(popped_);
  for (const Terminal& each : popped_) answered(each);
  Report report;
  while (stage_.exchange.reports.try_pop(report)) {
    stage_.witness.digest(report.index());
    const auto* refused = std::get_if<ReferenceRefused>(&report);
    if (refused != nullptr && writers_) writers_->refused(*refused);
  }
}

void Player::answered(const Terminal& terminal) {
  const std::optional<Job> job = stage_.ledger.answered(terminal);
  stage_.witness.digest(terminal.index());
  if (!job) return;
  stage_.witness.digest(job->id);
  mode_jobs_.erase(job->id);
  stage_.witness.stops.answered(job->id);
  settle(*job, terminal);
  if (probes_.erase(job->id) == 0) return;
  const auto* done = std::get_if<ParameterDone>(&terminal);
  const bool well = done != nullptr && done->result.outcome == cansync::Outcome::done &&
                    done->result.value == job->parameter.slave.value();
  probes_well_ = probes_well_ && well;
}

void Player::settle(const Job& job, const Terminal& terminal) {
  std::string how;
  if (const auto* refused = std::get_if<Refused>(&terminal)) {
    stage_.coverage.refused(refused->refusal);
    how = "refused, " + std::string(name(refused->refusal));
  } else if (const auto* command = std::get_if<CommandDone>(&terminal)) {
    stage_.coverage.ended(command->outcome);
    how = name(command->outcome);
  } else if (const auto* parameter = std::get_if<ParameterDone>(&terminal)) {
    stage_.coverage.ended(parameter->result.outcome);
    how = std::string(name(parameter->result.outcome)) + ", value " + std::to_string(parameter->result.value);
  } else if (const auto* transfer = std::get_if<TransferDone>(&terminal)) {
    stage_.coverage.ended(transfer->result.outcome);
    how = std::string(name(transfer->result.outcome)) + ", " + std::to_string(transfer->result.bytes) +
          " bytes";
  }
  if (stage_.tell) stage_.tell("answer " + std::to_string(job.id) + ": " + how);
  settle_words(job, terminal);
  if (job.kind == Job::Kind::parameter) settle_parameter(job, terminal);
  if (job.kind == Job::Kind::transfer) settle_transfer(job, terminal);
}

void Player::settle_words(const Job& job, const Terminal& terminal) {
  std::optional<MemoryTruth::Facts> memory;
  const sim::Drive* drive = job.kind == Job::Kind::transfer ? drive_of(job.slave) : nullptr;
  if (drive != nullptr) memory = stage_.memories.facts(job.id, *drive);
  const bool doubtful = stage_.plan.doubtful_answers(job.pushed, stage_.line.intervals());
  stage_.words.ended(terminal, memory, doubtful, state_, stage_.line.now());
}

void Player::settle_parameter(const Job& job, const Terminal& terminal) {
  const auto* done = std::get_if<ParameterDone>(&terminal);
  if (done == nullptr) {
    stage_.parameters.refused(job.parameter);
    return;
  }
  const bool doubtful = stage_.plan.doubtful_answers(job.pushed, stage_.line.intervals());
  stage_.parameters.answered(job.parameter, done->result, doubtful);
  if (done->result.outcome != cansync::Outcome::done) return;
  stage_.coverage.met(job.parameter.write ? Coverage::Met::writes_done : Coverage::Met::reads_done);
}

void Player::settle_transfer(const Job& job, const Terminal& terminal) {
  const auto* done = std::get_if<TransferDone>(&terminal);
  const cansync::TransferResult result = done != nullptr ? done->result : cansync::TransferResult{};
  if (const sim::Drive* drive = drive_of(job.slave)) {
    stage_.memories.answered(job.id, result, done == nullptr, *drive, stage_.line.intervals());
  }
  if (done == nullptr || result.outcome != cansync::Outcome::done) return;
  stage_.coverage.met(job.download ? Coverage::Met::downloads_done : Coverage::Met::uploads_done);
}

void Player::take_back() {
  // What still waits was never begun: the gateway answers for it.
  Request request;
  while (stage_.exchange.requests.try_pop(request)) {
    std::visit(
        [this](const auto& typed) {
          if constexpr (requires { typed.id; }) {
            if (stage_.ledger.open().contains(typed.id))
              answered(Refused{typed.id, cansync::Refusal::wrong_state});
          }
        },
        request);
  }
}

// --- one interval

void Player::act(std::uint64_t tick, const MasterSnapshot& now) {
  state_ = now.state;
  ReferenceTruth& references = stage_.witness.references;
  if (stage_.exchange.requests.size() == 0) {
    references.all_taken();
    stage_.witness.stops.all_taken();
    if (!cansync::is_active(now.state)) references.left_active();
  }
  if (writers_) live_writers(now);
  if (hangs()) return;
  hand_on_held_back();
  for (const Channel channel : {Channel::one, Channel::two}) {
    if (withdrawing_[index(channel)]) withdraw();
  }
  operate(tick, now);
  if (over()) {
    if (!writers_) write_references(now, true);
    return;
  }
  if (!writers_ && dice_.chance(stage_.plan.mix.references)) write_references(now, false);
  ask(tick);
}

void Player::moment() {
  if (hangs() || over() || !dice_.chance(20)) return;
  if (dice_.chance(300)) {
    cancel_one();
  } else {
    ask_parameter();
  }
}

void Player::write_references(const MasterSnapshot& now, bool steady) {
  const cansync::IntervalNumber interval = now.when.interval;
  if (!steady && stage_.line.intervals() < writer_back_) return;
  for (const Channel channel : {Channel::one, Channel::two}) {
    const std::uint32_t number = stage_.witness.references.next_number();
    cansync::ReferenceUpdate update;
    update.channel = channel;
    update.mapping_number = mapping_number_;
    update.value.fill(ReferenceTruth::value_of(number));
    update.valid_mask =
        steady || dice_.chance(900) ? 0x0F : static_cast<std::uint8_t>(1 + 2 * dice_.below(8));
    if (!steady && dice_.chance(100))
      update.release_intervals = static_cast<std::uint32_t>(dice_.between(2, 30));
    if (!steady && dice_.chance(50)) update.from_interval = interval + dice_.between(1, 40);
    if (!push(update, nullptr, "reference values " + std::to_string(number))) continue;
    stage_.witness.references.pushed(number, update);
  }
}

/// Programs go on while the gateway hangs.
void Player::live_writers(const MasterSnapshot& now) {
  if (over()) {
    writers_->settle_down(now.when.interval, mapping_number_);
  } else {
    writers_->live(now.when.interval, mapping_number_);
  }
  if (!hangs()) writers_->gateway(now);
}

void Player::withdraw() {
  for (const Channel channel : {Channel::one, Channel::two}) {
    withdrawing_[index(channel)] = !push(StopRelease{channel}, nullptr, "stop of release");
    if (!withdrawing_[index(channel)]) stage_.witness.references.withdrawn(channel);
  }
}

// --- the operator

void Player::ask_for_mode(Mode mode, bool force) {
  const Job job = new_job(Job::Kind::mode);
  stage_.witness.references.mode_asked();
  if (push(ModeRequest{job.id, mode, force}, &job, "mode " + std::to_string(static_cast<int>(mode)))) {
    mode_jobs_.insert(job.id);
  }
}

void Player::operate(std::uint64_t tick, const MasterSnapshot& now) {
  const bool bus_off = now.controller.state == can::ControllerState::bus_off;
  if (bus_off) stage_.coverage.met(Coverage::Met::bus_off);
  // A controller needs its time to come back; who resets it again begins that time anew.
  if (bus_off && mode_jobs_.empty() && tick >= reset_again_ && (over() || dice_.chance(50))) {
    ask_for_mode(Mode::reset_can, false);
    reset_again_ = tick + kResetTime;
  }
  if (!over()) {
    // Somebody who has stopped the line starts it again after a while.
    const bool stopped = !cansync::is_synchronous(now.state);
    if (stopped && mode_jobs_.empty() && dice_.chance(100)) ask_for_mode(Mode::restart, false);
    return;
  }
  mend(tick, now);
  probe(tick);
}

void Player::mend(std::uint64_t tick, const MasterSnapshot& now) {
  if (!cursors_reset_) {
    const Job job = new_job(Job::Kind::setting);
    cursors_reset_ = push(SetCursors{job.id, cansync::Cursor{}, cansync::Cursor{}, cansync::Cursor{}}, &job,
                          "all cursors automatic");
  }
  // Else the values of the writers may have gone too far from those sent last.
  if (limits_lifted_ < cansync::kChannels) {
    stage_.witness.references.set_limits({});
    const Job job = new_job(Job::Kind::setting);
    const auto value = static_cast<std::uint8_t>(limits_lifted_ * cansync::kWords);
    limits_lifted_ += push(SetReferenceLimits{job.id, value, {}}, &job, "no limits") ? 1u : 0u;
  }
  if (!mode_jobs_.empty() || tick % 4 != 0) return;
  if (!cansync::is_synchronous(now.state)) {
    ask_for_mode(Mode::set_up, false);
  } else if (!cansync::is_active(now.state) && now.synchronized == now.configured) {
    ask_for_mode(Mode::run, false);
  }
}

void Player::probe(std::uint64_t tick) {
  Recovery& recovery = stage_.recovery;
  const auto& drives = stage_.plan.drives;
  if (recovery.phase() == Recovery::Phase::recovering && recovery.ready()) recovery.probing();
  if (recovery.phase() != Recovery::Phase::probing) return;
  const std::size_t most = std::min<std::size_t>(stage_.plan.settings.command_channel.parameter_queue, 4);
  while (next_probe_ < drives.size() && probes_.size() < most) {
    Job job = new_job(Job::Kind::parameter);
    job.parameter.id = job.id;
    job.parameter.slave = drives[next_probe_].slave.number;
    job.parameter.number = *cansync::ParameterNumber::from(sim::parameter::slave_number);
    job.parameter.monitoring_time = recovery.allowed() * stage_.plan.interval();
    if (!push(job.parameter, &job, "probe of slave " + std::to_string(job.parameter.slave.value()))) return;
    stage_.parameters.pushed(job.parameter);
    probes_.insert(job.id);
    ++next_probe_;
  }
  if (next_probe_ == drives.size() && probes_.empty()) recovery.probed(probes_well_, tick);
}

}  // namespace cansyncd::campaign
