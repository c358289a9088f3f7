#include "cansync/master.h"

#include <algorithm>
#include <array>

#include "cansync/channel/command_channel.h"
#include "cansync/process_data/process_data.h"
#include "cansync/settings/timing.h"
#include "cansync/supervision/answer_balance.h"
#include "cansync/supervision/sole_master.h"
#include "cansync/supervision/strays.h"
#include "cansync/supervision/supervision.h"
#include "cansync/telegram/telegram.h"

namespace cansync {
namespace {

Channel channel_of(Slot slot) noexcept {
  return slot == Slot::reference_one ? Channel::one : Channel::two;
}

bool is_from_master(const can::Frame& frame) noexcept {
  if (!frame.is_standard_data()) return false;
  const std::uint32_t channel = identifier::channel_of(frame.id);
  return frame.id == identifier::action || channel == identifier::reference_one ||
         channel == identifier::reference_two || channel == identifier::command;
}

}  // namespace

struct Master::Impl {
  Impl(const MasterSettings& given, MasterListener& told)
      : settings(given),
        listener(told),
        times(slot_times(given.bit_rate)),
        supervision(settings, told),
        process(settings, told),
        command_channel(settings, supervision, told),
        sole(given.startup.listen, times.interval) {}

  MasterSettings settings;
  MasterListener& listener;
  const SlotTimes& times;
  Supervision supervision;
  ProcessData process;
  CommandChannel command_channel;
  SoleMaster sole;
  Strays strays;
  AnswerBalance balance;
  std::array<std::optional<SlaveNumber>, kChannels> polled = {};  ///< for actual values in this interval
  State state = State::start_up;
  IntervalNumber now = 0;
  bool edge = false;  ///< the interval has begun with one
  MasterCounters counters;
  /// The newest telegram of a slot, by which its echo is known.
  struct Taken {
    can::Frame frame;
    Duration planned{};  ///< start of its slot on the timeline: no echo of it ends before
  };
  std::array<Taken, kSlots> taken = {};

  Duration on_timeline(Duration since_sync) const noexcept {
    return static_cast<Duration::rep>(now) * times.interval + since_sync;
  }

  void second_master(std::uint32_t identifier) noexcept {
    ++counters.second_master;
    const bool was_silent = !sole.granted();
    const bool first = sole.heard(identifier);
    const bool tolerated = is_active(state) && settings.startup.on_second_master == OnSecondMaster::report;
    if (tolerated && !was_silent) sole.accept();
    const bool ends = is_synchronous(state) && !sole.granted();
    if (first || ends) {
      listener.event({.code = MasterEvent::Code::second_master,
                      .slave = std::nullopt,
                      .detail = identifier,
                      .found = static_cast<std::uint32_t>(sole.access())});
    }
    if (ends) enter(State::start_up, ControlCommand::cold_restart);
  }

  void watch_second_master() noexcept {
    const std::uint64_t row = sole.pass_interval();
    if (row == 0) return;
    const auto telegrams = static_cast<std::uint32_t>(std::min<std::uint64_t>(row, UINT32_MAX));
    listener.event({MasterEvent::Code::second_master_gone, std::nullopt, telegrams});
  }

  bool deliver(const Telegram& telegram, Duration since_sync) noexcept {
    if (const auto* actual = std::get_if<ActualTelegram>(&telegram)) {
      supervision.seen(actual->slave);
      if (!is_active(state) || !process.receive(*actual)) return false;
      tell_status(*actual);
      return true;
    }
    if (const auto* reply = std::get_if<ParameterReply>(&telegram)) return respond(*reply, since_sync);
    return respond(*std::get_if<TransferReply>(&telegram), since_sync);
  }

  /// The status word may stand among the actual values.
  void tell_status(const ActualTelegram& telegram) noexcept {
    const auto& where = settings.slaves[telegram.slave.value()].status_value;
    if (!where) return;
    const auto word = position_of(process.actual_mapping(telegram.slave)[index(telegram.channel)], *where);
    if (word) supervision.came(telegram.slave, telegram.word[*word]);
  }

  template <class Reply>
  bool respond(const Reply& reply, Duration since_sync) noexcept {
    supervision.seen(reply.slave);
    if (command_channel.receive(reply, on_timeline(since_sync))) return true;
    supervision.heard(reply.slave);
    return false;
  }

  /// A question went to this slave.
  void asked(unsigned place, std::optional<SlaveNumber> slave) noexcept {
    if (place < kChannels) polled[place] = slave;
    if (!slave) return;
    balance.asked(place, *slave, now, supervision.given_up().has(*slave));
    supervision.asked(*slave);
  }

  /// Is there one drive of this number, and is it known?
  void weigh(const Telegram& telegram) noexcept {
    // While another master asks, answers say nothing of who is there.
    if (!is_synchronous(state) || sole.other()) return;
    const Strays::Origin from = Strays::origin(telegram);
    supervision.came(from.slave);
    const bool fits =
        from.place < kChannels ? polled[from.place] == from.slave : command_channel.fits_last(telegram);
    if (!balance.answered(from.place, from.slave, now, fits)) supervision.answered_twice(from.slave);
  }

  /// A telegram of a slave: somebody takes it, or it is counted by what is wrong with it.
  void take_or_count(const can::Frame& frame, const Telegram& telegram, Duration since_sync) noexcept {
    const auto* actual = std::get_if<ActualTelegram>(&telegram);
    weigh(telegram);
    const auto asked = actual != nullptr ? process.asked(actual->channel) : command_channel.asked();
    if (deliver(telegram, since_sync)) return strays.taken(frame, telegram);
    ++counters.unexpected;
    ++counters.unexpected_by_kind[static_cast<unsigned>(strays.judge(frame, telegram, asked))];
  }

  void enter(State to, ControlCommand command) noexcept {
    const State from = state;
    state = to;
    if (!is_synchronous(to)) {
      if (const auto asked = command_channel.asked()) strays.given_up(*asked);
      command_channel.end_all();
      sole.accept_nobody();
    }
    if (!is_active(to)) process.stop();
    if (is_synchronous(to) && !is_synchronous(from)) {
      supervision.begin(now);
      balance.begin();
      command_channel.begin();
    }
    listener.state_changed(from, to, command);
  }
};

Master::Master(const MasterSettings& settings, MasterListener& listener)
    : impl_(std::make_unique<Impl>(settings, listener)) {}
Master::~Master() = default;

// --- the interval

void Master::begin_interval(IntervalNumber n) noexcept {
  impl_->now = n;
  impl_->edge = true;
  ++impl_->counters.intervals;
  impl_->supervision.begin_interval(n, is_active(impl_->state));
  const auto missed = impl_->process.begin_interval(n);
  for (const Channel channel : {Channel::one, Channel::two}) {
    const auto slave = missed[index(channel)];
    if (!slave) continue;
    impl_->supervision.missed_actual(*slave);
    impl_->strays.missed(channel, *slave);
  }
  impl_->polled = {};
  impl_->command_channel.begin_interval(n);
  impl_->watch_second_master();
}

void Master::pass_interval(IntervalNumber n) noexcept {
  impl_->now = n;
  impl_->edge = false;
  impl_->command_channel.pass_interval(n);
  // Reference values grow older all the same.
  if (is_active(impl_->state)) static_cast<void>(impl_->process.begin_interval(n));
  impl_->watch_second_master();
}

Duration Master::latest_start(Slot slot) const noexcept {
  switch (slot) {
    case Slot::reference_one:
      return impl_->times.reference_one;
    case Slot::reference_two:
      return impl_->times.reference_two;
    case Slot::command:
      break;
  }
  return impl_->times.command;
}

Duration Master::planned_start(Slot slot) const noexcept {
  const bool early = slot == Slot::command && !is_active(impl_->state);
  return (early ? impl_->times.reference_one : latest_start(slot)) - impl_->settings.send_margin;
}

std::optional<can::Frame> Master::take(Slot slot) noexcept {
  Impl::Taken& taken = impl_->taken[static_cast<unsigned>(slot)];
  taken.planned = impl_->on_timeline(planned_start(slot));
  if (!impl_->edge || !impl_->sole.granted()) return std::nullopt;
  if (slot == Slot::command) {
    if (!is_synchronous(impl_->state)) return std::nullopt;
    // Taking the next command gives up the answer to the last one.
    if (const auto unanswered = impl_->command_channel.asked()) impl_->strays.given_up(*unanswered);
    const auto telegram = impl_->command_channel.take();
    return telegram ? std::optional(taken.frame = encode(*telegram)) : std::nullopt;
  }
  if (!is_active(impl_->state)) return std::nullopt;
  const auto telegram = impl_->process.telegram(channel_of(slot));
  return telegram ? std::optional(taken.frame = encode(*telegram)) : std::nullopt;
}

void Master::sent(Slot slot) noexcept {
  ++impl_->counters.telegrams_sent;
  if (slot == Slot::command) {
    impl_->command_channel.sent();
    impl_->asked(kChannels, impl_->command_channel.asked());
  } else {
    const Channel channel = channel_of(slot);
    impl_->process.sent(channel);
    impl_->asked(index(channel), impl_->process.asked(channel));
  }
}

void Master::left_out(Slot slot) noexcept {
  ++impl_->counters.left_out;
  if (slot == Slot::command) {
    impl_->command_channel.left_out();
  } else {
    impl_->process.left_out(channel_of(slot));
  }
}

void Master::transmitted(const can::Frame& frame, Duration since_sync) noexcept {
  const Duration end = impl_->on_timeline(since_sync);
  // A telegram that was held up may look like the one of this interval.
  const auto is = [&](Slot slot) {
    const Impl::Taken& taken = impl_->taken[static_cast<unsigned>(slot)];
    return frame == taken.frame && end >= taken.planned;
  };
  if (is(Slot::command)) impl_->command_channel.transmitted(end);
  if (is(Slot::reference_one)) impl_->process.transmitted(Channel::one);
  if (is(Slot::reference_two)) impl_->process.transmitted(Channel::two);
}

void Master::receive(const can::Frame& frame, Duration since_sync) noexcept {
  // Its identifier tells a master, whatever stands in the frame.
  const bool from_master = is_from_master(frame);
  if (from_master) impl_->second_master(frame.id);
  const Decoded decoded = decode(frame);
  if (const auto* error = std::get_if<DecodeError>(&decoded)) {
    ++impl_->counters.rejected[static_cast<unsigned>(*error)];
    return;
  }
  if (from_master) return;
  impl_->take_or_count(frame, *std::get_if<Telegram>(&decoded), since_sync);
}

void Master::other_sync() noexcept {
  impl_->second_master(0);
}

bool Master::second_master() const noexcept {
  return impl_->sole.other();
}

std::uint32_t Master::second_master_identifier() const noexcept {
  return impl_->sole.other_identifier();
}

BusAccess Master::access() const noexcept {
  return impl_->sole.access();
}

bool Master::silent() const noexcept {
  return is_synchronous(impl_->state) && !impl_->sole.granted();
}

// --- requests

void Master::bus_lost() noexcept {
  impl_->supervision.bus_lost();
  impl_->command_channel.bus_lost();
  impl_->process.bus_lost();
}

void Master::bus_away() noexcept {
  impl_->sole.bus_away();
}

void Master::bus_returned() noexcept {
  impl_->sole.bus_returned();
}

Refusal Master::submit(const ParameterRequest& request) noexcept {
  return is_synchronous(impl_->state) ? impl_->command_channel.submit(request) : Refusal::wrong_state;
}
Refusal Master::submit(const TransferRequest& request) noexcept {
  return is_synchronous(impl_->state) ? impl_->command_channel.submit(request) : Refusal::wrong_state;
}
Refusal Master::submit(const ControlWordRequest& request) noexcept {
  return is_synchronous(impl_->state) ? impl_->command_channel.submit(request) : Refusal::wrong_state;
}
Refusal Master::submit(const BroadcastRequest& request) noexcept {
  return is_synchronous(impl_->state) ? impl_->command_channel.submit(request) : Refusal::wrong_state;
}
Refusal Master::submit(const ReferenceUpdate& update) noexcept {
  return is_active(impl_->state) ? impl_->process.update(update) : Refusal::wrong_state;
}

Refusal Master::cancel(JobId id) noexcept {
  const auto asked = impl_->command_channel.asked();
  const Refusal refusal = impl_->command_channel.cancel(id);
  if (asked && !impl_->command_channel.asked()) impl_->strays.given_up(*asked);
  return refusal;
}

Refusal Master::release(SlaveNumber slave, bool force) noexcept {
  return is_synchronous(impl_->state) ? impl_->supervision.release(slave, force) : Refusal::wrong_state;
}

void Master::stop_release(Channel channel, std::uint32_t hold) noexcept {
  impl_->process.stop_release(channel, hold);
}

Refusal Master::control(ControlCommand command, bool force) noexcept {
  const auto to = next(Role::master, impl_->state, command);
  if (!to) return Refusal::wrong_state;
  if (command == ControlCommand::enable_active && !force &&
      !impl_->supervision.missing(impl_->settings.startup.enable).empty()) {
    return Refusal::slaves_missing;
  }
  if (command == ControlCommand::start_synchronous) {
    // From active operation, too: what was accepted there is not accepted in set-up.
    const BusAccess access = impl_->sole.unforced();
    if (access != BusAccess::granted && !force)
      return access == BusAccess::other_master ? Refusal::other_master : Refusal::listening;
    if (access != BusAccess::granted) impl_->sole.accept();
  }
  if (command != ControlCommand::reset_can) impl_->enter(*to, command);
  return Refusal::none;
}

Refusal Master::set_reference_mapping(const ProcessMapping& mapping) noexcept {
  const Refusal refusal = impl_->process.set_reference_mapping(mapping);
  if (refusal == Refusal::none) impl_->settings.process.reference_mapping = mapping;
  return refusal;
}

std::uint64_t Master::mapping_number() const noexcept {
  return impl_->process.mapping_number();
}

Refusal Master::set_actual_mapping(SlaveNumber slave, const ProcessMapping& mapping) noexcept {
  const Refusal refusal = impl_->process.set_actual_mapping(slave, mapping);
  if (refusal == Refusal::none) impl_->settings.slaves[slave.value()].actual_mapping = mapping;
  return refusal;
}

Refusal Master::set_polling(Channel channel, const Cursor& cursor) noexcept {
  const Refusal refusal = impl_->process.set_polling(channel, cursor);
  if (refusal == Refusal::none) impl_->settings.process.polling[index(channel)] = cursor;
  return refusal;
}

void Master::set_reference_limits(std::uint8_t value, const ReferenceLimits& limits) noexcept {
  if (value >= kValues) return;
  impl_->process.set_reference_limits(value, limits);
  impl_->settings.process.reference_limits[value] = limits;
}

void Master::set_maximum_slave(SlaveNumber slave) noexcept {
  impl_->settings.process.maximum_slave = slave;
  impl_->process.set_maximum_slave(slave);
  impl_->command_channel.set_maximum_slave(slave);
}

Refusal Master::set_command_cursors(const Cursor& control_word, const Cursor& parameter,
                                    const Cursor& transfer) noexcept {
  const Refusal refusal = impl_->command_channel.set_cursors(control_word, parameter, transfer);
  if (refusal == Refusal::none) {
    impl_->settings.command_channel.control_word = control_word;
    impl_->settings.command_channel.parameter = parameter;
    impl_->settings.command_channel.transfer = transfer;
  }
  return refusal;
}

// --- what is known

State Master::state() const noexcept {
  return impl_->state;
}
IntervalNumber Master::interval() const noexcept {
  return impl_->now;
}
const MasterSettings& Master::settings() const noexcept {
  return impl_->settings;
}
const SlaveStatus& Master::slave(SlaveNumber slave) const noexcept {
  return impl_->supervision.status(slave);
}
const ActualValues& Master::actual(SlaveNumber slave) const noexcept {
  return impl_->process.actual(slave);
}
const ReleaseStatus& Master::release(Channel channel) const noexcept {
  return impl_->process.release(channel);
}
SlaveMask Master::duplicate_slaves() const noexcept {
  return impl_->supervision.duplicates();
}
SlaveMask Master::unknown_slaves() const noexcept {
  return impl_->supervision.unknown();
}
const MasterCounters& Master::counters() const noexcept {
  impl_->counters.references_not_released = impl_->process.not_released();
  return impl_->counters;
}
std::size_t Master::open_parameter_jobs() const noexcept {
  return impl_->command_channel.open_parameter_jobs();
}
std::size_t Master::open_transfers() const noexcept {
  return impl_->command_channel.open_transfers();
}

}  // namespace cansync
