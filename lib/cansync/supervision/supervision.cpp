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
  for (unsigned i = 0; i < kSlaves; ++i) status_[i].configured = settings.slaves[i].configured;
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
  to_activate_ = SlaveMask::all();
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
  if (suspect_.has(slave)) return true;
  if (released_.has(slave)) return false;
  return (!active_ && !given_up_.has(slave) && !synchronized_.has(slave)) ||
         next_read_[slave.value()] <= now_;
}

SlaveMask Supervision::wanted() const noexcept {
  SlaveMask slaves;
  for (const SlaveNumber slave : SlaveMask{without(configured_, released_).bits | suspect_.bits}) {
    slaves.set(slave, wanted(slave));
  }
  return slaves;
}

IntervalNumber Supervision::pause(SlaveNumber slave) const noexcept {
  if (released_.has(slave)) return std::max<IntervalNumber>(period_, 1);
  return std::max<IntervalNumber>(active_ && given_up_.has(slave) ? lost_period_ : recheck_, 1);
}

std::optional<SlaveNumber> Supervision::next_due(SlaveMask left_alone) noexcept {
  const SlaveMask first = first_round_.empty() ? without(wanted(), left_alone) : SlaveMask{};
  for (unsigned step = 1; step <= kSlaves; ++step) {
    const SlaveNumber slave = *SlaveNumber::from((last_read_ + step) % kSlaves);
    if (first.empty() ? due(slave) && !left_alone.has(slave) : first.has(slave)) return slave;
  }
  return std::nullopt;
}

std::optional<Telegram> Supervision::telegram(SlaveMask left_alone) noexcept {
  if (!to_activate_.empty()) {
    return ActionCommand{to_activate_, settings_.startup.activate_command, settings_.startup.activate_data,
                         0};
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
  if (std::get_if<ActionCommand>(&telegram) != nullptr) {
    for (const SlaveNumber slave : to_activate_) activated_[slave.value()] = now_;
    to_activate_ = {};
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
  if (!synchronized && now_ - activated_[slave.value()] >= activate_again_) to_activate_.set(slave);
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
  // It may have started anew between two commands, and then waits to be activated.
  if (!synchronized) to_activate_.set(slave);
  take(slave, synchronized ? SlaveEvent::synchronized : SlaveEvent::not_synchronized);
  tell(synchronized ? MasterEvent::Code::slave_synchronized : MasterEvent::Code::slave_not_synchronized,
       slave);
  if (synchronized && is_held_out(status.state)) synchronized_again(slave);
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
  ++status.times_lost;
  take(slave, SlaveEvent::gone);
}

void Supervision::bus_lost() noexcept {
  // An activation that nobody answered after may never have been on the bus.
  if (responding_.empty()) to_activate_ = SlaveMask::all();
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
  switch (rule) {
    case EnableRule::all_synchronized:
      return without(configured_, released_);
    case EnableRule::all_responding:
      return without(configured_, responding_);
    case EnableRule::any:
      break;
  }
  return {};
}

// --- slaves that were away, from their first answer until they are released

/// The one place where a slave's state changes.
void Supervision::change(SlaveNumber slave, SlaveEvent event) noexcept {
  SlaveState& state = at(slave).state;
  state = next(state, event).value_or(state);
  released_.set(slave, state == SlaveState::released);
  held_out_.set(slave, is_held_out(state));
  lost_.set(slave, state == SlaveState::lost);
  checking_.set(slave, state == SlaveState::checking);
  if (state != SlaveState::checking) checks_[slave.value()].stop();
}

void Supervision::take(SlaveNumber slave, SlaveEvent event) noexcept {
  change(slave, event);
  listener_.slave_status(slave, at(slave));
}

void Supervision::synchronized_again(SlaveNumber slave) noexcept {
  ReturnCheck& check = checks_[slave.value()];
  check.begin(settings_.slaves[slave.value()], slave, monitoring_);
  if (check.running()) {
    take(slave, SlaveEvent::check_begun);
    return;
  }
  take(slave, SlaveEvent::check_passed);
  tell(MasterEvent::Code::slave_released, slave);
}

bool Supervision::check_answered(SlaveNumber slave, const ParameterReply& reply) noexcept {
  ReturnCheck& check = checks_[slave.value()];
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
  const ReturnCheck& check = checks_[slave.value()];
  if (check.passed()) {
    tell(MasterEvent::Code::slave_checked, slave, check.checked());
    take(slave, SlaveEvent::check_passed);
    tell(MasterEvent::Code::slave_released, slave);
    return;
  }
  const ParameterResult& found = check.found();
  const bool slave_error = found.outcome == Outcome::slave_error;
  MasterEvent event{MasterEvent::Code::slave_check_failed, slave, check.failed().number.value()};
  event.expected = check.failed().value;
  event.found = slave_error ? static_cast<std::uint16_t>(found.error) : found.value;
  event.outcome = found.outcome;
  take(slave, SlaveEvent::check_failed);
  listener_.event(event);
}

Refusal Supervision::release(SlaveNumber slave, bool force) noexcept {
  const SlaveStatus& status = at(slave);
  if (!status.configured) return Refusal::slave_not_configured;
  if (!status.responds) return Refusal::slave_lost;
  if (!held_out_.has(slave)) return Refusal::not_held;
  if (!status.synchronized) {
    to_activate_.set(slave);
    next_read_[slave.value()] = now_;
  } else if (force) {
    take(slave, SlaveEvent::check_passed);
    tell(MasterEvent::Code::slave_released, slave, 1);
  } else {
    synchronized_again(slave);
  }
  return Refusal::none;
}

}  // namespace cansync
