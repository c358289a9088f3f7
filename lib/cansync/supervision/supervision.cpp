#include "cansync/supervision/supervision.h"

#include <algorithm>
#include <utility>

#include "cansync/settings/timing.h"
#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

/// Bit 15 of a status word: the slave is synchronized (M 3.2.0.1).
constexpr std::uint16_t kSynchronizedBit = 0x8000;

/// How often a lost slave is asked when released ones are never asked, and at most one that is not released.
constexpr Duration kLostPeriod = std::chrono::seconds(1);
constexpr Duration kRecheck = std::chrono::milliseconds(100);

/// A slave that now gives its status word and now refuses it is told of once in so long; so long may it answer
/// without one.
constexpr Duration kRefusedAgain = std::chrono::seconds(5);

/// What one answer too many weighs, from which weight on there are two drives, and most that is noted. Each
/// question takes one off: two drives are found with the eighth question, and what comes twice now and then
/// never adds up.
constexpr std::uint8_t kOneTooMany = 4;
constexpr std::uint8_t kTwoDrives = 24;
constexpr std::uint8_t kMostEvidence = 32;

/// A reply that names no code, or 0, is refused all the same.
std::uint16_t refusal_code(const ParameterReply& reply) noexcept {
  const auto answer = error_answer(reply);
  const auto code = answer ? static_cast<std::uint16_t>(answer->error) : std::uint16_t{0};
  return code != 0 ? code : static_cast<std::uint16_t>(ParameterError::unspecified);
}

SlaveMask without(SlaveMask from, SlaveMask slaves) noexcept {
  return {from.bits & ~slaves.bits};
}

}  // namespace

Supervision::Supervision(const MasterSettings& settings, MasterListener& listener) noexcept
    : settings_(settings), listener_(listener), configured_(settings.configured()) {
  const Duration interval = slot_times(settings.bit_rate).interval;
  const auto intervals = [&](Duration time) { return static_cast<IntervalNumber>(time / interval); };
  period_ = intervals(settings.startup.status_period);
  lost_period_ = period_ != 0 ? period_ : intervals(kLostPeriod);
  recheck_ = std::min(lost_period_, intervals(kRecheck));
  monitoring_ = std::max<IntervalNumber>(intervals(settings.command_channel.parameter_monitoring), 1);
  activate_again_ = intervals(kActivateAgain);
  refused_again_ = intervals(kRefusedAgain);
  for (const SlaveNumber slave : SlaveMask::all()) {
    status_[slave.value()].configured = configured_.has(slave);
    expects_.set(slave, configured_.has(slave) && !expected_of(settings.slaves[slave.value()]).empty());
  }
}

void Supervision::tell(MasterEvent::Code code, std::optional<SlaveNumber> slave,
                       std::uint32_t detail) noexcept {
  listener_.event({code, slave, detail});
}

void Supervision::begin(IntervalNumber now) noexcept {
  now_ = now;
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    status_[i].responds = false;
    status_[i].synchronized = false;
    status_[i].status_known = false;
    status_[i].status_error = 0;
    refused_[i] = {};
    silence_[i] = 0;
    change(slave, SlaveEvent::begun);
    suspect_again_[i] = now;
    next_read_[i] = now;
    if (configured_.has(slave)) listener_.slave_status(slave, status_[i]);
  }
  responding_ = {};
  synchronized_ = {};
  suspect_ = {};
  given_up_ = {};
  identified_ = {};
  doubtful_ = {};
  duplicates_ = {};
  tolerated_ = {};
  evidence_ = {};
  unknown_ = {};
  census_ = settings_.startup.census ? without(SlaveMask::all(), configured_) : SlaveMask{};
  to_activate_ = activated_at_start();
  first_round_ = configured_;
  last_read_ = kSlaves - 1;
}

bool Supervision::due(SlaveNumber slave) const noexcept {
  if (!configured_.has(slave)) return false;
  if (first_round_.has(slave)) return true;
  if (!first_round_.empty()) return false;
  if (wanted(slave)) return true;
  return (!active_ || period_ != 0) && released_.has(slave) && next_read_[slave.value()] <= now_;
}

/// True when the slave's status word should not wait until there is nothing else to do.
bool Supervision::wanted(SlaveNumber slave) const noexcept {
  if (suspect_.has(slave) || waits_for_proof(slave)) return true;
  if (released_.has(slave)) return false;
  return (!active_ && !given_up_.has(slave) && !synchronized_.has(slave)) ||
         next_read_[slave.value()] <= now_;
}

SlaveMask Supervision::wanted() const noexcept {
  SlaveMask slaves;
  for (const SlaveNumber slave :
       SlaveMask{without(configured_, released_).bits | suspect_.bits | doubtful_.bits}) {
    slaves.set(slave, wanted(slave));
  }
  return slaves;
}

IntervalNumber Supervision::pause(SlaveNumber slave) const noexcept {
  if (released_.has(slave)) return std::max<IntervalNumber>(period_, 1);
  return std::max<IntervalNumber>(active_ && given_up_.has(slave) ? lost_period_ : recheck_, 1);
}

std::optional<SlaveNumber> Supervision::next_due(SlaveMask left_alone) noexcept {
  // In set-up one that is held out is asked all the time, and must not keep the others from being asked.
  const SlaveMask first = active_ && first_round_.empty() ? without(wanted(), left_alone) : SlaveMask{};
  for (unsigned step = 1; step <= kSlaves; ++step) {
    const SlaveNumber slave = *SlaveNumber::from((last_read_ + step) % kSlaves);
    if (first.empty() ? due(slave) && !left_alone.has(slave) : first.has(slave)) return slave;
  }
  return std::nullopt;
}

std::optional<Telegram> Supervision::telegram(SlaveMask left_alone) noexcept {
  if (const SlaveMask slaves = may_be_activated(); !slaves.empty()) {
    return ActionCommand{slaves, settings_.startup.activate_command, settings_.startup.activate_data, 0};
  }
  const auto slave = next_due(left_alone);
  if (!slave) return std::nullopt;
  ParameterCommand command;
  command.slave = *slave;
  // Checked with the settings: 0..4095.
  command.number =
      ParameterNumber::from(settings_.slaves[slave->value()].status_parameter).value_or(ParameterNumber{});
  return command;
}

void Supervision::sent(const Telegram& telegram) noexcept {
  if (const auto* action = std::get_if<ActionCommand>(&telegram)) {
    for (const SlaveNumber slave : action->slaves) activated_[slave.value()] = now_;
    to_activate_ = without(to_activate_, action->slaves);
  } else if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
    last_read_ = command->slave.value();
    next_read_[last_read_] = now_ + pause(command->slave);
    first_round_.set(command->slave, false);
  }
}

void Supervision::answered(const ParameterReply& reply) noexcept {
  const SlaveNumber slave = reply.slave;
  if (reply.error) return status_refused(slave, refusal_code(reply));
  const auto answer = reply.busy ? std::nullopt : read_answer(reply);
  if (answer) return take_status(slave, static_cast<std::uint16_t>(answer->value & 0xFFFF));
  StatusRefusal& refused = refused_[slave.value()];
  if (!refused.wordless_since) refused.wordless_since = now_;
  if (refused.wordless_told || now_ - *refused.wordless_since < refused_again_) return;
  refused.wordless_told = true;
  tell_refused(slave, reply.busy ? Outcome::timeout : Outcome::no_answer);
}

void Supervision::came(SlaveNumber slave, std::uint16_t status_word) noexcept {
  if (!at(slave).responds || first_round_.has(slave)) return;
  next_read_[slave.value()] = now_ + pause(slave);
  take_status(slave, status_word);
}

void Supervision::take_status(SlaveNumber slave, std::uint16_t word) noexcept {
  SlaveStatus& status = at(slave);
  refused_[slave.value()].wordless_since.reset();
  refused_[slave.value()].wordless_told = false;
  const bool gives_it_again = std::exchange(status.status_error, std::uint16_t{0}) != 0;
  const bool changed = gives_it_again || !status.status_known || word != status.status_word;
  status.status_word = word;
  status.status_known = true;
  const bool synchronized = (word & kSynchronizedBit) != 0;
  if (!synchronized && now_ - activated_[slave.value()] >= activate_again_) activate_again(slave);
  if (synchronized != status.synchronized) {
    set_synchronized(slave, synchronized);
  } else if (changed) {
    listener_.slave_status(slave, status);
  }
}

void Supervision::status_refused(SlaveNumber slave, std::uint16_t code) noexcept {
  SlaveStatus& status = at(slave);
  if (status.status_error == code) return;
  const bool edge = std::exchange(status.status_error, code) == 0;
  listener_.slave_status(slave, status);
  if (edge) tell_refused(slave, Outcome::slave_error);
}

void Supervision::tell_refused(SlaveNumber slave, Outcome outcome) noexcept {
  std::optional<IntervalNumber>& told = refused_[slave.value()].told;
  if (told && now_ - *told < refused_again_) return;
  told = now_;
  MasterEvent event{MasterEvent::Code::slave_status_refused, slave,
                    settings_.slaves[slave.value()].status_parameter};
  event.found = outcome == Outcome::slave_error ? status(slave).status_error : 0;
  event.outcome = outcome;
  listener_.event(event);
}

void Supervision::set_synchronized(SlaveNumber slave, bool synchronized) noexcept {
  SlaveStatus& status = at(slave);
  status.synchronized = synchronized;
  synchronized_.set(slave, synchronized);
  // Two drives say now this, now that: neither ends that they are held.
  if (status.state == SlaveState::held && maybe_two().has(slave) && duplicates_.has(slave))
    return listener_.slave_status(slave, status);
  const bool waits = synchronized && unidentified().has(slave);
  // It may have started anew between two commands, and then waits to be activated.
  if (!synchronized) to_activate_.set(slave);
  if (waits) listener_.slave_status(slave, status);
  if (!waits) take(slave, synchronized ? SlaveEvent::synchronized : SlaveEvent::not_synchronized);
  tell(synchronized ? MasterEvent::Code::slave_synchronized : MasterEvent::Code::slave_not_synchronized,
       slave);
  // And it may be another one.
  if (!synchronized && expects_.has(slave)) identify(slave);
  if (synchronized && !waits && is_held_out(status.state)) synchronized_again(slave);
  if (synchronized && synchronized_ == configured_) tell(MasterEvent::Code::all_synchronized, std::nullopt);
}

void Supervision::seen(SlaveNumber slave) noexcept {
  at(slave).last_seen = now_;
}

void Supervision::responded(SlaveNumber slave, std::optional<Duration> response, bool slow) noexcept {
  SlaveStatus& status = at(slave);
  ++status.answers;
  silence_[slave.value()] = 0;
  suspect_.set(slave, false);
  if (response) {
    status.last_response = *response;
    status.longest_response = std::max(status.longest_response, *response);
  }
  if (slow) ++status.slow_answers;
  if (status.responds || !status.configured) return;
  status.responds = true;
  responding_.set(slave);
  given_up_.set(slave, false);
  const bool returned = status.state == SlaveState::lost;
  // A slave that comes back was not there for the first activation, and its status word is not known.
  if (first_round_.empty() && (status.unanswered > 0 || returned)) to_activate_.set(slave);
  next_read_[slave.value()] = now_;
  if (returned) ++status.times_returned;
  take(slave, SlaveEvent::answered);
  tell(returned ? MasterEvent::Code::slave_returned : MasterEvent::Code::slave_responds, slave);
  if (expects_.has(slave)) identify(slave);
}

bool Supervision::silent(SlaveNumber slave) noexcept {
  ++at(slave).unanswered;
  std::uint8_t& silence = silence_[slave.value()];
  if (silence < 255) ++silence;
  if (silence < settings_.startup.lost_after) {
    if (period_ != 0) next_read_[slave.value()] = now_;
    return false;
  }
  const bool first = !given_up_.has(slave);
  given_up_.set(slave);
  return first;
}

void Supervision::lost(SlaveNumber slave, unsigned jobs) noexcept {
  SlaveStatus& status = at(slave);
  status.jobs_ended += jobs;
  next_read_[slave.value()] = now_ + pause(slave);
  if (!status.responds) {
    listener_.slave_status(slave, status);
    return;
  }
  const bool was_synchronized = status.synchronized;
  forget(slave);
  responding_.set(slave, false);
  suspect_.set(slave, false);
  synchronized_.set(slave, false);
  tell(MasterEvent::Code::slave_lost, slave, jobs);
  if (was_synchronized) tell(MasterEvent::Code::slave_not_synchronized, slave);
}

/// A slave that answered is away.
void Supervision::forget(SlaveNumber slave) noexcept {
  SlaveStatus& status = at(slave);
  status.responds = false;
  status.synchronized = false;
  status.status_known = false;
  status.status_error = 0;
  refused_[slave.value()] = {};
  identified_.set(slave, false);
  tolerated_.set(slave, false);
  forget_evidence(slave);
  ++status.times_lost;
  take(slave, SlaveEvent::gone);
}

void Supervision::bus_lost() noexcept {
  // An activation that nobody answered after may never have been on the bus.
  if (responding_.empty()) to_activate_ = activated_at_start();
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    next_read_[i] = now_;
    silence_[i] = 0;
    if (at(slave).responds) forget(slave);
  }
  given_up_ = {};
  responding_ = {};
  synchronized_ = {};
  suspect_ = {};
}

void Supervision::missed_actual(SlaveNumber slave) noexcept {
  ++at(slave).missed_actual;
  if (!at(slave).responds || period_ == 0) return;
  // Ask at once instead of waiting for the period; only an unanswered command makes a slave lost.
  next_read_[slave.value()] = std::min(next_read_[slave.value()], now_);
  if (suspect_again_[slave.value()] > now_) return;
  suspect_.set(slave);
  suspect_again_[slave.value()] = now_ + recheck_;
}

SlaveMask Supervision::missing(EnableRule rule) const noexcept {
  // Whatever the rule, reference values are for the drives that are meant: a drive that answers has said who
  // it is, and each that is expected was asked.
  SlaveMask unknown{unidentified().bits & (responding_.bits | first_round_.bits)};
  unknown.bits |= maybe_two().bits & configured_.bits;
  switch (rule) {
    case EnableRule::all_synchronized:
      return {without(configured_, released_).bits | unknown.bits};
    case EnableRule::all_responding:
      return {without(configured_, responding_).bits | unknown.bits};
    case EnableRule::any:
      break;
  }
  return unknown;
}

// --- from a slave's first answer until it is released

/// The one place where a slave's state changes. A list of parameters ends with the state it was begun in.
void Supervision::change(SlaveNumber slave, SlaveEvent event) noexcept {
  SlaveStatus& status = at(slave);
  const SlaveState before = status.state;
  status.state = next(before, event).value_or(before);
  released_.set(slave, status.state == SlaveState::released);
  held_out_.set(slave, is_held_out(status.state));
  lost_.set(slave, status.state == SlaveState::lost);
  if (status.state != SlaveState::held) status.held.reset();
  if (status.state == before) return;
  checks_[slave.value()].stop();
  checking_.set(slave, false);
}

void Supervision::take(SlaveNumber slave, SlaveEvent event) noexcept {
  change(slave, event);
  listener_.slave_status(slave, at(slave));
}

void Supervision::begin_check(SlaveNumber slave, std::span<const ParameterValue> list, bool write) noexcept {
  ParameterCheck& check = checks_[slave.value()];
  check.begin(list, write, slave, monitoring_);
  checking_.set(slave, check.running());
}

void Supervision::identify(SlaveNumber slave, bool again) noexcept {
  identified_.set(slave, false);
  asked_again_.set(slave, again);
  take(slave, SlaveEvent::asked_who);
  begin_check(slave, expected_of(settings_.slaves[slave.value()]), false);
}

/// The slave is the drive expected, and only now activated. It may be synchronized already.
void Supervision::identified(SlaveNumber slave) noexcept {
  identified_.set(slave);
  const SlaveStatus& status = at(slave);
  if (!status.synchronized) {
    activate(slave);
    listener_.slave_status(slave, status);
  } else if (status.state == SlaveState::starting) {
    take(slave, SlaveEvent::synchronized);
  } else {
    synchronized_again(slave);
  }
}

void Supervision::activate(SlaveNumber slave) noexcept {
  to_activate_.set(slave);
  next_read_[slave.value()] = now_;
}

/// It may have missed the activation, or have been exchanged since it was asked who it is, so quickly that no answer
/// was missing: one that does not synchronize says nothing new.
void Supervision::activate_again(SlaveNumber slave) noexcept {
  if (!expects_.has(slave) || tolerated_.has(slave)) {
    to_activate_.set(slave);
  } else if (identified_.has(slave) && !to_activate_.has(slave)) {
    identify(slave, true);
  }
}

void Supervision::synchronized_again(SlaveNumber slave) noexcept {
  const SlaveSettings& settings = settings_.slaves[slave.value()];
  const auto list = checked_on_return(settings);
  if (!list.empty()) {
    take(slave, SlaveEvent::check_begun);
    begin_check(slave, list, settings.on_return == OnReturn::write);
    return;
  }
  take(slave, SlaveEvent::check_passed);
  tell(MasterEvent::Code::slave_released, slave);
}

bool Supervision::check_answered(SlaveNumber slave, const ParameterReply& reply) noexcept {
  ParameterCheck& check = checks_[slave.value()];
  // The list was given up or begun anew since it was asked: the slave is there, and that is all it says.
  if (!check.waits_for_answer()) return true;
  const Step step = check.answered(reply, now_);
  if (step == Step::ended) end_check(slave);
  return step != Step::ignored;
}

SlaveMask Supervision::busy_with_checks() const noexcept {
  SlaveMask busy;
  for (const SlaveNumber slave : checking_) busy.set(slave, checks_[slave.value()].busy());
  return busy;
}

void Supervision::check_times() noexcept {
  for (const SlaveNumber slave : checking_) {
    if (checks_[slave.value()].check_time(now_) == Step::ended) end_check(slave);
  }
}

void Supervision::end_check(SlaveNumber slave) noexcept {
  const ParameterCheck& check = checks_[slave.value()];
  const bool who = unidentified().has(slave);
  checking_.set(slave, false);
  // Either of two may have answered: asked on until it is known whether they are.
  if (who && check.passed() && maybe_two().has(slave)) return identify(slave, asked_again_.has(slave));
  if (check.passed()) {
    const bool news = !who || !asked_again_.has(slave);
    if (news) {
      tell(who ? MasterEvent::Code::slave_identified : MasterEvent::Code::slave_checked, slave,
           check.checked());
    }
    if (who) return identified(slave);
    take(slave, SlaveEvent::check_passed);
    tell(MasterEvent::Code::slave_released, slave);
    return;
  }
  const ParameterResult& found = check.found();
  const bool slave_error = found.outcome == Outcome::slave_error;
  MasterEvent event{who ? MasterEvent::Code::wrong_drive : MasterEvent::Code::slave_check_failed, slave,
                    check.failed().number.value()};
  event.expected = check.failed().value;
  event.found = slave_error ? static_cast<std::uint16_t>(found.error) : found.value;
  event.outcome = found.outcome;
  hold(slave, who ? SlaveEvent::wrong_drive : SlaveEvent::check_failed, event);
}

void Supervision::hold(SlaveNumber slave, SlaveEvent event, const MasterEvent& reason) noexcept {
  change(slave, event);
  at(slave).held = reason;
  listener_.slave_status(slave, at(slave));
  listener_.event(reason);
}

Refusal Supervision::release(SlaveNumber slave, bool force) noexcept {
  const SlaveStatus& status = at(slave);
  if (!status.configured) return Refusal::slave_not_configured;
  if (!status.responds) return Refusal::slave_lost;
  if (!held_out().has(slave)) return Refusal::not_held;
  // One that is not synchronized may have been exchanged since it was asked.
  const bool unknown = unidentified().has(slave) || (expects_.has(slave) && !status.synchronized);
  forget_evidence(slave);
  tolerated_.set(slave, force);
  if (unknown && !force) {
    identify(slave);
    return Refusal::none;
  }
  if (force) {
    identified_.set(slave);
    begin_check(slave, {}, false);
  }
  if (!status.synchronized) {
    // One that was held now waits for SYNC alone.
    if (force) take(slave, SlaveEvent::not_synchronized);
    activate(slave);
  } else if (force) {
    take(slave, status.state == SlaveState::starting ? SlaveEvent::synchronized : SlaveEvent::check_passed);
    tell(MasterEvent::Code::slave_released, slave, 1);
  } else {
    synchronized_again(slave);
  }
  return Refusal::none;
}

// --- two drives of one number, and numbers that are not configured

/// Slaves as which two drives may answer. What is meant for one of them would reach both.
SlaveMask Supervision::maybe_two() const noexcept {
  if (settings_.startup.on_duplicate != OnDuplicate::hold) return {};
  return without({doubtful_.bits | duplicates_.bits}, tolerated_);
}

void Supervision::asked(SlaveNumber slave) noexcept {
  std::uint8_t& evidence = evidence_[slave.value()];
  if (evidence == 0 || --evidence != 0) return;
  doubtful_.set(slave, false);
  // Either may have said who it is, and the other one may be left.
  if (!expects_.has(slave) || tolerated_.has(slave)) return;
  if (identified_.has(slave) ? !at(slave).synchronized : checking_.has(slave))
    identify(slave, identified_.has(slave));
}

void Supervision::forget_evidence(SlaveNumber slave) noexcept {
  evidence_[slave.value()] = 0;
  doubtful_.set(slave, false);
  duplicates_.set(slave, false);
}

/// In set-up a slave that has answered too often is asked until it is known whether it is two.
bool Supervision::waits_for_proof(SlaveNumber slave) const noexcept {
  return !active_ && doubtful_.has(slave) && !duplicates_.has(slave);
}

void Supervision::answered_twice(SlaveNumber slave) noexcept {
  if (!configured_.has(slave)) return;
  std::uint8_t& evidence = evidence_[slave.value()];
  evidence = std::min<std::uint8_t>(static_cast<std::uint8_t>(evidence + kOneTooMany), kMostEvidence);
  doubtful_.set(slave);
  if (evidence < kTwoDrives || duplicates_.has(slave)) return;
  const bool holds = settings_.startup.on_duplicate == OnDuplicate::hold && !tolerated_.has(slave);
  // Actual values of one that is lost: it is held when it answers a command again.
  if (holds && !at(slave).responds) return;
  duplicates_.set(slave);
  const MasterEvent event{MasterEvent::Code::duplicate_slave, slave};
  if (!holds) return listener_.event(event);
  // Who was asked is not known any more: either may have answered.
  identified_.set(slave, false);
  hold(slave, SlaveEvent::duplicated, event);
}

void Supervision::came(SlaveNumber slave) noexcept {
  if (!settings_.startup.census || configured_.has(slave) || unknown_.has(slave)) return;
  unknown_.set(slave);
  tell(MasterEvent::Code::unknown_slave, slave);
}

}  // namespace cansync
