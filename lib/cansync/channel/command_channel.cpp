#include "cansync/channel/command_channel.h"

#include <algorithm>
#include <utility>

#include "cansync/settings/timing.h"
#include "cansync/telegram/reply_payload.h"

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
      broadcasts_{FixedQueue<WaitingBroadcast>(at_least_one(settings_.broadcast_queue)),
                  FixedQueue<WaitingBroadcast>(at_least_one(settings_.broadcast_queue)),
                  FixedQueue<WaitingBroadcast>(at_least_one(settings_.broadcast_queue))},
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
  if (asked->kind != ParameterCommand::Kind::read) {
    if (confirms_write(reply) && write_sub_slave(reply)) sends_sub_slave_.set(reply.slave);
    return false;
  }
  const auto answer = read_answer(reply);
  if (answer && answer->doubleword) sends_sub_slave_.set(reply.slave);
  return answer && !answer->sub_slave && sends_sub_slave_.has(reply.slave);
}

bool CommandChannel::receive(const ParameterReply& reply, Duration end) noexcept {
  // What comes before the command was on the bus answers an earlier one.
  if (asked_.slave != reply.slave || command_end_ < Duration(0)) return false;
  if (asked_.kind != Kind::none && belongs_to_a_write(reply)) return false;
  if (asked_.kind == Kind::supervision) {
    if (!supervision_.is_answer(reply)) return false;
    asked_.kind = Kind::none;
    note_response(reply.slave, end, data_bytes(reply));
    supervision_.answered(reply);
    return true;
  }
  if (asked_.kind == Kind::census) {
    // Whatever it says of its status word: it is there.
    if (reply.number != std::get<ParameterCommand>(asked_.telegram).number) return false;
    asked_.kind = Kind::none;
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
  note_response(reply.slave, end, data_bytes(reply));
  return true;
}

bool CommandChannel::receive(const TransferReply& reply, Duration end) noexcept {
  if (asked_.slave != reply.slave || command_end_ < Duration(0)) return false;
  if (now_ < late_cancels_[reply.slave.value()]) note_late_cancel(asked_);
  if (asked_.kind == Kind::cancel) {
    // Any answer but busy: a slave that has nothing open may say so with an error. One that is busy for ever
    // must not keep the others waiting.
    if (reply.busy) {
      open_transfers_.unanswered(reply.slave);
    } else {
      open_transfers_.known(reply.slave);
    }
    asked_.kind = Kind::none;
    note_response(reply.slave, end, data_bytes(reply));
    return true;
  }
  if (asked_.kind != Kind::transfer) return false;
  TransferJob& job = *transfers_.front(reply.slave);
  const std::uint32_t before = job.result().bytes;
  const Step step = job.answered(reply, now_);
  if (step == Step::ignored) return false;
  asked_.kind = Kind::none;
  note_response(reply.slave, end, data_bytes(reply));
  if (job.result().bytes != before) listener_.transfer_progress(job.request().id, job.result().bytes);
  if (step == Step::ended) finish_transfer(reply.slave);
  return true;
}

bool CommandChannel::fits_last(const Telegram& reply) const noexcept {
  const auto* asked = std::get_if<ParameterCommand>(&asked_.telegram);
  if (const auto* parameter = std::get_if<ParameterReply>(&reply))
    return asked != nullptr && asked->slave == parameter->slave && asked->number == parameter->number;
  const auto* transfer = std::get_if<TransferReply>(&reply);
  return transfer != nullptr && asked == nullptr && asked_.slave == transfer->slave;
}

void CommandChannel::transmitted(Duration end) noexcept {
  command_end_ = end;
  settle_echo(Outcome::done);
}

/// Ends the control word or broadcast that was handed over last.
void CommandChannel::settle_echo(Outcome outcome) noexcept {
  if (const auto id = std::exchange(echo_of_, std::nullopt)) listener_.command_done(*id, outcome);
}

void CommandChannel::settle_unanswered() noexcept {
  // It may stand in the controller and go out later: sending it again could make two of it.
  settle_echo(outcome_of(JobKnown::handed_over, JobEnd::unanswered));
  const Chosen asked = asked_;
  asked_.kind = Kind::none;
  if (asked.kind == Kind::none || asked.kind == Kind::census) return;
  note_late_cancel(asked);
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
  check_words();
  for (const SlaveNumber slave : parameters_.waiting()) {
    ParameterJob& job = *parameters_.front(slave);
    if (!job.monitored()) {
      const Duration time = job.request().monitoring_time;
      job.monitor_until(now_ + std::max<IntervalNumber>(
                                   intervals(time > Duration(0) ? time : settings_.parameter_monitoring), 1));
    } else if (now_ >= job.deadline()) {
      job.end(JobEnd::time, now_);
      finish_parameter(slave);
    }
  }
  for (const SlaveNumber slave : transfers_.waiting()) {
    if (transfers_.front(slave)->check_time(now_) == Step::ended) finish_transfer(slave);
  }
}

/// Ends the control words and broadcasts that were not sent in time.
void CommandChannel::check_words() noexcept {
  const auto over = [this](const auto& waiting) { return now_ > waiting.last; };
  const Outcome outcome = outcome_of(JobKnown::not_sent, JobEnd::time);
  control_words_.remove_if(over, [&](JobId id) { listener_.command_done(id, outcome); });
  for (auto& queue : broadcasts_) {
    queue.remove_each(over,
                      [&](const auto& waiting) { listener_.command_done(waiting.request.id, outcome); });
  }
}

void CommandChannel::finish_parameter(SlaveNumber slave) noexcept {
  const ParameterJob& job = *parameters_.front(slave);
  note_late_answer(job);
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
