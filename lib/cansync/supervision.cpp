#include "cansync/supervision.h"

#include <algorithm>

#include "cansync/timing.h"

namespace cansync {
namespace {

/// Bit 15 of a status word: the slave is synchronized (M 3.2.0.1).
constexpr std::uint16_t kSynchronizedBit = 0x8000;

}  // namespace

Supervision::Supervision(const MasterSettings& settings, MasterListener& listener) noexcept
    : settings_(settings), listener_(listener), configured_(settings.configured()) {
  const Duration interval = slot_times(settings.bit_rate).interval;
  period_ = static_cast<IntervalNumber>(settings.startup.status_period / interval);
  for (unsigned i = 0; i < kSlaves; ++i) status_[i].configured = settings.slaves[i].configured;
}

void Supervision::tell(MasterEvent::Code code, std::optional<SlaveNumber> slave) noexcept {
  listener_.event({code, slave, 0});
}

void Supervision::begin(IntervalNumber now) noexcept {
  now_ = now;
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    status_[i].responds = false;
    status_[i].synchronized = false;
    status_[i].status_known = false;
    silence_[i] = 0;
    next_read_[i] = now;
    if (configured_.has(slave)) listener_.slave_status(slave, status_[i]);
  }
  responding_ = {};
  synchronized_ = {};
  suspect_ = {};
  to_activate_ = SlaveMask::all();
  first_round_ = configured_;
  last_read_ = kSlaves - 1;
}

bool Supervision::due(SlaveNumber slave) const noexcept {
  if (!configured_.has(slave)) return false;
  if (first_round_.has(slave)) return true;
  if (!first_round_.empty()) return false;
  if (!active_) return !synchronized_.has(slave) || next_read_[slave.value()] <= now_;
  return period_ != 0 && next_read_[slave.value()] <= now_;
}

std::optional<SlaveNumber> Supervision::next_due() noexcept {
  const bool suspects = active_ && !suspect_.empty() && first_round_.empty();
  for (unsigned step = 1; step <= kSlaves; ++step) {
    const SlaveNumber slave = *SlaveNumber::from((last_read_ + step) % kSlaves);
    if (suspects ? suspect_.has(slave) : due(slave)) return slave;
  }
  return std::nullopt;
}

std::optional<Telegram> Supervision::telegram() noexcept {
  if (!to_activate_.empty()) {
    return ActionCommand{to_activate_, settings_.startup.activate_command, settings_.startup.activate_data,
                         0};
  }
  const auto slave = next_due();
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
    to_activate_ = {};
  } else if (const auto* command = std::get_if<ParameterCommand>(&telegram)) {
    last_read_ = command->slave.value();
    next_read_[last_read_] = now_ + std::max<IntervalNumber>(period_, 1);
    first_round_.set(command->slave, false);
  }
}

bool Supervision::answered(SlaveNumber slave, const ParameterReply& reply) noexcept {
  if (reply.number.value() != settings_.slaves[slave.value()].status_parameter) return false;
  if (reply.busy || reply.error || reply.payload_size < 2) return true;
  SlaveStatus& status = at(slave);
  const std::uint16_t word = load_word(reply.payload.data());
  const bool changed = !status.status_known || word != status.status_word;
  status.status_word = word;
  status.status_known = true;
  const bool synchronized = (word & kSynchronizedBit) != 0;
  if (synchronized != status.synchronized) {
    set_synchronized(slave, synchronized);
  } else if (changed) {
    listener_.slave_status(slave, status);
  }
  return true;
}

void Supervision::set_synchronized(SlaveNumber slave, bool synchronized) noexcept {
  at(slave).synchronized = synchronized;
  synchronized_.set(slave, synchronized);
  // It may have started anew between two commands, and then waits to be activated.
  if (!synchronized) to_activate_.set(slave);
  listener_.slave_status(slave, at(slave));
  tell(synchronized ? MasterEvent::Code::slave_synchronized : MasterEvent::Code::slave_not_synchronized,
       slave);
  if (synchronized && synchronized_ == configured_) tell(MasterEvent::Code::all_synchronized, std::nullopt);
}

void Supervision::seen(SlaveNumber slave) noexcept {
  at(slave).last_seen = now_;
}

void Supervision::responded(SlaveNumber slave, std::optional<Duration> response, bool slow) noexcept {
  SlaveStatus& status = at(slave);
  ++status.answers;
  silence_[slave.value()] = 0;
  if (response) {
    status.last_response = *response;
    status.longest_response = std::max(status.longest_response, *response);
  }
  if (slow) ++status.slow_answers;
  if (status.responds || !status.configured) return;
  status.responds = true;
  responding_.set(slave);
  // A slave that comes back was not there for the first activation, and its status word is not known.
  if (first_round_.empty() && (status.unanswered > 0 || cut_off_.has(slave))) to_activate_.set(slave);
  cut_off_.set(slave, false);
  next_read_[slave.value()] = now_;
  listener_.slave_status(slave, status);
  tell(MasterEvent::Code::slave_responds, slave);
}

void Supervision::silent(SlaveNumber slave) noexcept {
  SlaveStatus& status = at(slave);
  ++status.unanswered;
  std::uint8_t& silence = silence_[slave.value()];
  if (silence < 255) ++silence;
  if (!status.responds || silence < settings_.startup.lost_after) return;
  status.responds = false;
  status.status_known = false;
  responding_.set(slave, false);
  suspect_.set(slave, false);
  const bool was_synchronized = status.synchronized;
  status.synchronized = false;
  synchronized_.set(slave, false);
  listener_.slave_status(slave, status);
  tell(MasterEvent::Code::slave_lost, slave);
  if (was_synchronized) tell(MasterEvent::Code::slave_not_synchronized, slave);
}

void Supervision::bus_lost() noexcept {
  for (unsigned i = 0; i < kSlaves; ++i) {
    const SlaveNumber slave = *SlaveNumber::from(i);
    SlaveStatus& status = at(slave);
    next_read_[i] = now_;
    if (!status.responds) continue;
    status.responds = false;
    status.synchronized = false;
    status.status_known = false;
    cut_off_.set(slave);
    listener_.slave_status(slave, status);
  }
  responding_ = {};
  synchronized_ = {};
  suspect_ = {};
}

void Supervision::missed_actual(SlaveNumber slave) noexcept {
  ++at(slave).missed_actual;
  // Ask at once instead of waiting for the period; only an unanswered command makes a slave lost.
  if (at(slave).responds && period_ != 0)
    next_read_[slave.value()] = std::min(next_read_[slave.value()], now_);
}

SlaveMask Supervision::missing(EnableRule rule) const noexcept {
  switch (rule) {
    case EnableRule::all_synchronized:
      return {configured_.bits & ~synchronized_.bits};
    case EnableRule::all_responding:
      return {configured_.bits & ~responding_.bits};
    case EnableRule::any:
      break;
  }
  return {};
}

}  // namespace cansync
