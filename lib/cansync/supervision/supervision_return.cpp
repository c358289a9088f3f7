#include "cansync/supervision/supervision.h"

/// Supervision's other half: slaves that were away, from their first answer until they are released.
namespace cansync {

/// The one place where a slave's state changes.
void Supervision::change(SlaveNumber slave, SlaveEvent event) noexcept {
  SlaveState& state = at(slave).state;
  state = next(state, event).value_or(state);
  released_.set(slave, state == SlaveState::released);
  held_out_.set(slave, is_held_out(state));
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
  const Step step = checks_[slave.value()].answered(reply, now_);
  if (step == Step::ended) end_check(slave);
  return step != Step::ignored;
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
