#include "cansync/command_channel.h"

#include <algorithm>

#include "cansync/timing.h"

namespace cansync {
namespace {

std::size_t at_least_one(std::uint16_t capacity) noexcept {
  return std::max<std::size_t>(capacity, 1);
}

}  // namespace

CommandChannel::CommandChannel(const MasterSettings& settings, Supervision& supervision,
                               MasterListener& listener)
    : master_(settings),
      settings_(settings.command_channel),
      supervision_(supervision),
      listener_(listener),
      configured_(settings.configured()),
      maximum_slave_(settings.process.maximum_slave),
      broadcasts_{FixedQueue<BroadcastRequest>(at_least_one(settings_.broadcast_queue)),
                  FixedQueue<BroadcastRequest>(at_least_one(settings_.broadcast_queue)),
                  FixedQueue<BroadcastRequest>(at_least_one(settings_.broadcast_queue))},
      control_words_(kSlaves, FixedQueue<ControlWordRequest>(at_least_one(settings_.control_word_queue))),
      parameters_(at_least_one(settings_.parameter_queue)),
      transfers_(at_least_one(settings_.transfer_queue)) {
  control_word_scan_.cursor = settings_.control_word;
  parameter_scan_.cursor = settings_.parameter;
  transfer_scan_.cursor = settings_.transfer;
}

IntervalNumber CommandChannel::intervals(Duration time) const noexcept {
  const Duration interval = slot_times(master_.bit_rate).interval;
  return static_cast<IntervalNumber>((time + interval - Duration(1)) / interval);
}

void CommandChannel::begin_interval(IntervalNumber now) noexcept {
  now_ = now;
  for (Scan* scan : {&control_word_scan_, &parameter_scan_, &transfer_scan_}) {
    scan->rising = scan->rising >= maximum_slave_.value() ? 0 : static_cast<std::uint8_t>(scan->rising + 1);
  }
}

Refusal CommandChannel::set_cursors(const Cursor& control_word, const Cursor& parameter,
                                    const Cursor& transfer) noexcept {
  for (const Cursor* cursor : {&control_word, &parameter, &transfer}) {
    if (cursor->kind == Cursor::Kind::fixed && !configured_.has(cursor->slave))
      return Refusal::slave_not_configured;
  }
  settings_.control_word = control_word_scan_.cursor = control_word;
  settings_.parameter = parameter_scan_.cursor = parameter;
  settings_.transfer = transfer_scan_.cursor = transfer;
  return Refusal::none;
}

// --- which command goes out

std::optional<SlaveNumber> CommandChannel::next_slave(const Scan& scan, SlaveMask waiting) const noexcept {
  if (waiting.empty() || scan.cursor.kind == Cursor::Kind::nobody) return std::nullopt;
  if (scan.cursor.kind == Cursor::Kind::fixed) {
    return waiting.has(scan.cursor.slave) ? std::optional(scan.cursor.slave) : std::nullopt;
  }
  if (settings_.serving == Serving::scan) {
    const SlaveNumber slave = *SlaveNumber::from(scan.rising);
    return waiting.has(slave) ? std::optional(slave) : std::nullopt;
  }
  for (unsigned step = 1; step <= kSlaves; ++step) {
    const SlaveNumber slave = *SlaveNumber::from((scan.last + step) % kSlaves);
    if (waiting.has(slave)) return slave;
  }
  return std::nullopt;
}

bool CommandChannel::share_due(const Scan& scan, SlaveMask waiting) const noexcept {
  return settings_.minimum_share != 0 && !waiting.empty() && scan.passed_over + 1 >= settings_.minimum_share;
}

void CommandChannel::count_share(Scan& scan, SlaveMask waiting, bool served) noexcept {
  if (served || waiting.empty()) {
    scan.passed_over = 0;
  } else if (scan.passed_over < settings_.minimum_share) {
    ++scan.passed_over;
  }
}

std::optional<Telegram> CommandChannel::take() noexcept {
  settle_unanswered();
  check_times();
  chosen_.kind = Kind::none;
  choose();
  count_share(parameter_scan_, parameters_.waiting(), chosen_.kind == Kind::parameter);
  count_share(transfer_scan_, transfers_waiting(), chosen_.kind == Kind::transfer);
  count_share(check_scan_, supervision_.checking(), chosen_.kind == Kind::check);
  count_share(supervision_scan_, pressing(), chosen_.kind == Kind::supervision);
  if (chosen_.kind == Kind::none) return std::nullopt;
  return chosen_.telegram;
}

SlaveMask CommandChannel::pressing() const noexcept {
  return supervision_.pressing() ? SlaveMask::all() : SlaveMask{};
}

void CommandChannel::choose() noexcept {
  if (choose_broadcast(0)) return;
  if (supervision_.urgent() && choose_supervision()) return;
  if (choose_cancel()) return;
  if (share_due(supervision_scan_, pressing()) && choose_supervision()) return;
  if (share_due(parameter_scan_, parameters_.waiting()) && choose_parameter()) return;
  if (share_due(transfer_scan_, transfers_waiting()) && choose_transfer()) return;
  if (share_due(check_scan_, supervision_.checking()) && choose_check()) return;
  if (choose_broadcast(1) || choose_broadcast(2) || choose_control_word()) return;
  if (choose_parameter() || choose_transfer() || choose_check()) return;
  choose_supervision();
}

/// What a control word ends with that was taken and would be refused by now.
Outcome CommandChannel::ended_by(Refusal refused) noexcept {
  return refused == Refusal::slave_lost ? Outcome::slave_lost : Outcome::slave_held;
}

bool CommandChannel::choose_broadcast(std::uint8_t priority) noexcept {
  auto& queue = broadcasts_[priority];
  // Since it was taken a slave may have been lost or held out.
  for (; !queue.empty(); queue.pop()) {
    const Refusal refused = enabling_refused(queue.front().action);
    if (refused == Refusal::none) break;
    listener_.command_done(queue.front().id, ended_by(refused));
  }
  if (queue.empty()) return false;
  chosen_ = {Kind::broadcast, {}, priority, queue.front().action};
  return true;
}

bool CommandChannel::choose_control_word() noexcept {
  while (const auto slave = next_slave(control_word_scan_, control_words_waiting_)) {
    auto& queue = control_words_[slave->value()];
    const ActionCommand action{SlaveMask::of(*slave), kCommandControlWord, 0, queue.front().control_word};
    const Refusal refused = enabling_refused(action);
    if (refused == Refusal::none) {
      chosen_ = {Kind::control_word, *slave, 0, action};
      return true;
    }
    listener_.command_done(queue.front().id, ended_by(refused));
    queue.pop();
    control_words_waiting_.set(*slave, !queue.empty());
  }
  return false;
}

bool CommandChannel::choose_parameter() noexcept {
  const auto slave = next_slave(parameter_scan_, parameters_.waiting());
  if (!slave) return false;
  chosen_ = {Kind::parameter, *slave, 0, parameters_.front(*slave)->telegram()};
  return true;
}

bool CommandChannel::choose_transfer() noexcept {
  const auto slave = next_slave(transfer_scan_, transfers_waiting());
  if (!slave) return false;
  chosen_ = {Kind::transfer, *slave, 0, transfers_.front(*slave)->telegram()};
  return true;
}

/// Transfers wait until the slave has been told to forget what it may have open.
SlaveMask CommandChannel::transfers_waiting() const noexcept {
  return {transfers_.waiting().bits & ~open_transfers_.unknown().bits};
}

bool CommandChannel::choose_cancel() noexcept {
  const std::uint32_t slaves = open_transfers_.unknown().bits & supervision_.responding().bits;
  if (slaves == 0) return false;
  const SlaveNumber slave = *SlaveNumber::from(static_cast<unsigned>(__builtin_ctz(slaves)));
  chosen_ = {Kind::cancel, slave, 0, cancel_transfer(slave)};
  return true;
}

bool CommandChannel::choose_check() noexcept {
  const auto slave = next_slave(check_scan_, supervision_.checking());
  if (!slave) return false;
  chosen_ = {Kind::check, *slave, 0, supervision_.check_telegram(*slave)};
  return true;
}

bool CommandChannel::choose_supervision() noexcept {
  const auto telegram = supervision_.telegram();
  if (!telegram) return false;
  const auto* command = std::get_if<ParameterCommand>(&*telegram);
  chosen_ = {Kind::supervision, command != nullptr ? command->slave : SlaveNumber{}, 0, *telegram};
  return true;
}

void CommandChannel::sent() noexcept {
  asked_.kind = Kind::none;
  command_end_ = Duration(-1);
  const SlaveNumber slave = chosen_.slave;
  switch (chosen_.kind) {
    case Kind::none:
      return;
    case Kind::broadcast: {
      const JobId id = broadcasts_[chosen_.priority].front().id;
      broadcasts_[chosen_.priority].pop();
      listener_.command_done(id, Outcome::done);
      break;
    }
    case Kind::control_word: {
      auto& queue = control_words_[slave.value()];
      const JobId id = queue.front().id;
      queue.pop();
      control_words_waiting_.set(slave, !queue.empty());
      control_word_scan_.last = slave.value();
      listener_.command_done(id, Outcome::done);
      break;
    }
    case Kind::parameter:
      parameters_.front(slave)->sent(now_);
      parameter_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::transfer:
      transfers_.front(slave)->sent(now_);
      transfer_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::cancel:
      asked_ = chosen_;
      break;
    case Kind::check:
      supervision_.check_sent(slave);
      check_scan_.last = slave.value();
      asked_ = chosen_;
      break;
    case Kind::supervision:
      supervision_.sent(chosen_.telegram);
      if (std::get_if<ParameterCommand>(&chosen_.telegram) != nullptr) asked_ = chosen_;
      break;
  }
  chosen_.kind = Kind::none;
}

// --- answers

std::optional<Duration> CommandChannel::note_response(SlaveNumber slave, Duration end,
                                                      unsigned data_bytes) noexcept {
  if (command_end_ < Duration(0)) {
    supervision_.responded(slave, std::nullopt, false);
    return std::nullopt;
  }
  const SlotTimes& times = slot_times(master_.bit_rate);
  const Duration response = end - command_end_;
  // tRSPTO runs to the start of the answer; its length without stuff bits is 44 bits and its data.
  const Duration start = response - (44 + 8 * data_bytes) * times.bit_time();
  supervision_.responded(slave, response, start > times.response_timeout);
  return response;
}

/// Two bytes confirm a write, with the sub-slave address. As the answer to a read they would be a word
/// without it, which a slave does not send that is known to send the address.
bool CommandChannel::belongs_to_a_write(const ParameterReply& reply) noexcept {
  const auto* asked = std::get_if<ParameterCommand>(&asked_.telegram);
  if (asked == nullptr || reply.number != asked->number || reply.busy || reply.error) return false;
  const bool read = asked->kind == ParameterCommand::Kind::read;
  if (reply.payload_size == (read ? 6 : 2)) sends_sub_slave_.set(reply.slave);
  return read && reply.payload_size == 2 && sends_sub_slave_.has(reply.slave);
}

bool CommandChannel::receive(const ParameterReply& reply, Duration end) noexcept {
  // What comes before the command was on the bus answers an earlier one.
  if (asked_.slave != reply.slave || command_end_ < Duration(0)) return false;
  if (asked_.kind != Kind::none && belongs_to_a_write(reply)) return false;
  if (asked_.kind == Kind::supervision) {
    if (!supervision_.is_answer(reply)) return false;
    asked_.kind = Kind::none;
    note_response(reply.slave, end, 2u + reply.payload_size);
    supervision_.answered(reply);
    return true;
  }
  if (asked_.kind == Kind::check) {
    if (!supervision_.check_answered(reply.slave, reply)) return false;
  } else if (asked_.kind == Kind::parameter) {
    const Step step = parameters_.front(reply.slave)->answered(reply, now_);
    if (step == Step::ignored) return false;
    if (step == Step::ended) finish_parameter(reply.slave);
  } else {
    return false;
  }
  asked_.kind = Kind::none;
  note_response(reply.slave, end, 2u + reply.payload_size);
  return true;
}

bool CommandChannel::receive(const TransferReply& reply, Duration end) noexcept {
  if (asked_.slave != reply.slave || command_end_ < Duration(0)) return false;
  if (asked_.kind == Kind::cancel) {
    // Any answer but busy: a slave that has nothing open may say so with an error. One that is busy for ever
    // must not keep the others waiting.
    if (reply.busy) {
      open_transfers_.unanswered(reply.slave);
    } else {
      open_transfers_.known(reply.slave);
    }
    asked_.kind = Kind::none;
    note_response(reply.slave, end, 2u + reply.payload_size);
    return true;
  }
  if (asked_.kind != Kind::transfer) return false;
  TransferJob& job = *transfers_.front(reply.slave);
  const std::uint32_t before = job.result().bytes;
  const Step step = job.answered(reply, now_);
  if (step == Step::ignored) return false;
  asked_.kind = Kind::none;
  note_response(reply.slave, end, 2u + reply.payload_size);
  if (job.result().bytes != before) listener_.transfer_progress(job.request().id, job.result().bytes);
  if (step == Step::ended) finish_transfer(reply.slave);
  return true;
}

void CommandChannel::settle_unanswered() noexcept {
  const Chosen asked = asked_;
  asked_.kind = Kind::none;
  if (asked.kind == Kind::none) return;
  if (asked.kind == Kind::cancel) {
    // A slave that does not answer this one telegram is not gone.
    open_transfers_.unanswered(asked.slave);
    return;
  }
  if (asked.kind == Kind::parameter) {
    ParameterJob* job = parameters_.front(asked.slave);
    if (job->unanswered(settings_.repeat_unanswered_writes, now_) == Step::ended)
      finish_parameter(asked.slave);
  } else if (asked.kind == Kind::transfer) {
    if (transfers_.front(asked.slave)->unanswered(now_) == Step::ended) finish_transfer(asked.slave);
  }
  if (supervision_.silent(asked.slave)) supervision_.lost(asked.slave, end_jobs(asked.slave));
}

void CommandChannel::check_times() noexcept {
  supervision_.check_times();
  for (std::uint32_t left = parameters_.waiting().bits; left != 0; left &= left - 1) {
    const SlaveNumber slave = *SlaveNumber::from(static_cast<unsigned>(__builtin_ctz(left)));
    ParameterJob& job = *parameters_.front(slave);
    if (!job.monitored()) {
      const Duration time = job.request().monitoring_time;
      job.monitor_until(now_ + std::max<IntervalNumber>(
                                   intervals(time > Duration(0) ? time : settings_.parameter_monitoring), 1));
    } else if (now_ >= job.deadline()) {
      job.end(Outcome::timeout, now_);
      finish_parameter(slave);
    }
  }
  for (std::uint32_t left = transfers_.waiting().bits; left != 0; left &= left - 1) {
    const SlaveNumber slave = *SlaveNumber::from(static_cast<unsigned>(__builtin_ctz(left)));
    if (transfers_.front(slave)->check_time(now_) == Step::ended) finish_transfer(slave);
  }
}

void CommandChannel::finish_parameter(SlaveNumber slave) noexcept {
  const ParameterJob& job = *parameters_.front(slave);
  listener_.parameter_done(job.request().id, job.result());
  parameters_.pop(slave);
}

void CommandChannel::end_transfer(const TransferJob& job) noexcept {
  listener_.transfer_done(job.request().id, job.result());
}

void CommandChannel::finish_transfer(SlaveNumber slave) noexcept {
  const TransferJob& job = *transfers_.front(slave);
  end_transfer(job);
  if (job.left_open() && settings_.cancel_at_start) open_transfers_.forget(SlaveMask::of(slave));
  transfers_.pop(slave);
}

}  // namespace cansync
