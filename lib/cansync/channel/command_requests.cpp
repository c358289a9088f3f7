#include <algorithm>
#include <limits>

#include "cansync/channel/command_channel.h"

/// The command channel's other half: taking requests, cancelling them, and ending them all.
namespace cansync {
namespace {

/// A slave that is busy for ever must not keep a transfer from ending.
constexpr Duration kCancelPatience = std::chrono::seconds(1);

}  // namespace

void CommandChannel::begin() noexcept {
  if (settings_.cancel_at_start) open_transfers_.forget(configured_);
}

void CommandChannel::bus_lost() noexcept {
  if (!settings_.cancel_at_start) return;
  SlaveMask slaves = configured_;
  for (const SlaveNumber slave : SlaveMask::all()) {
    const TransferJob* job = transfers_.front(slave);
    if (job != nullptr && job->on_slave()) slaves.set(slave, false);
  }
  open_transfers_.forget(slaves);
}

bool CommandChannel::enables(const ActionCommand& action) const noexcept {
  return action.command == kCommandControlWord && cansync::enables(master_.startup, action.data_word);
}

ActionCommand CommandChannel::action_of(const ControlWordRequest& request) noexcept {
  return {SlaveMask::of(request.slave), kCommandControlWord, 0, request.control_word};
}

/// The last interval in which a control word or broadcast may be sent that is given now.
IntervalNumber CommandChannel::last_interval(Duration monitoring_time) const noexcept {
  const Duration time = monitoring_time > Duration(0) ? monitoring_time : settings_.command_monitoring;
  return now_ + std::max<IntervalNumber>(intervals(time), 1);
}

/// Ends what waits and would enable one of these slaves after the stop that is given now.
void CommandChannel::replace_enabling(SlaveMask slaves) noexcept {
  const auto replaced = [this](JobId id) { listener_.command_done(id, Outcome::replaced); };
  const auto enabling = [&](const auto& waiting) {
    const ActionCommand action = action_of(waiting.request);
    return (action.slaves.bits & slaves.bits) != 0 && enables(action) && !is_failsafe(waiting.request);
  };
  control_words_.remove_if(enabling, replaced);
  for (auto& queue : broadcasts_) {
    queue.remove_each(enabling, [&](const auto& waiting) { replaced(waiting.request.id); });
  }
}

/// Why this control word, which enables drives, is not for one of its slaves now. What stops a drive
/// passes always, also to one whose answers do not come.
Refusal CommandChannel::enabling_refused(const ActionCommand& action) const noexcept {
  if (!enables(action)) return Refusal::none;
  if ((action.slaves.bits & supervision_.away().bits) != 0) return Refusal::slave_lost;
  if ((action.slaves.bits & supervision_.held_out().bits) != 0) return Refusal::slave_held;
  return Refusal::none;
}

Refusal CommandChannel::submit(const ParameterRequest& request) noexcept {
  if (!configured_.has(request.slave)) return Refusal::slave_not_configured;
  if (supervision_.away().has(request.slave)) return Refusal::slave_lost;
  if (request.write && request.element != kValueElement) return Refusal::element_not_writable;
  if (request.write && request.format == ParameterFormat::word && request.value > 0xFFFF) {
    return Refusal::value_too_wide;
  }
  return parameters_.push(request.slave, ParameterJob(request)) != nullptr ? Refusal::none
                                                                           : Refusal::queue_full;
}

Refusal CommandChannel::submit(const TransferRequest& request) noexcept {
  if (!configured_.has(request.slave)) return Refusal::slave_not_configured;
  if (supervision_.away().has(request.slave)) return Refusal::slave_lost;
  if (request.data.empty()) return Refusal::length_zero;
  const std::uint16_t limit = std::min(master_.slaves[request.slave.value()].block_limit, kLongestBlock);
  if (request.block_size > limit) return Refusal::block_size;
  if (!settings_.allow_reserved_addresses && request.address <= 0xFF) return Refusal::address_reserved;
  const std::uint64_t steps = (request.data.size() - 1) / settings_.address_step;
  if (request.address + steps > 0xFFFFFFFFu) return Refusal::address_overflow;
  TransferLimits limits;
  limits.block_size = request.block_size != 0 ? request.block_size : limit;
  // Blocks must begin at whole start addresses.
  if (limits.block_size % settings_.address_step != 0) return Refusal::block_size;
  limits.telegram_repeats = settings_.telegram_repeats;
  limits.block_retries = settings_.block_retries;
  limits.address_step = settings_.address_step;
  const Duration time = request.monitoring_time;
  limits.monitoring =
      std::max<IntervalNumber>(intervals(time > Duration(0) ? time : settings_.transfer_monitoring), 1);
  limits.cancel_patience = intervals(kCancelPatience);
  return transfers_.push(request.slave, TransferJob(request, limits)) != nullptr ? Refusal::none
                                                                                 : Refusal::queue_full;
}

Refusal CommandChannel::submit(const ControlWordRequest& request) noexcept {
  if (!configured_.has(request.slave)) return Refusal::slave_not_configured;
  const ActionCommand action = action_of(request);
  if (const Refusal refused = enabling_refused(action); refused != Refusal::none) return refused;
  if (!request.failsafe && control_words_.failsafe().has(request.slave)) {
    listener_.command_done(request.id, Outcome::replaced);
    return Refusal::none;
  }
  const bool stops = !enables(action) || request.failsafe;
  if (stops) replace_enabling(action.slaves);
  if (control_words_.waiting().has(request.slave)) {
    listener_.command_done(control_words_.of(request.slave).request.id, Outcome::replaced);
  }
  const IntervalNumber last =
      request.failsafe ? std::numeric_limits<IntervalNumber>::max() : last_interval(request.monitoring_time);
  control_words_.put({request, last, stops});
  return Refusal::none;
}

Refusal CommandChannel::submit(const BroadcastRequest& request) noexcept {
  if (request.priority > 2) return Refusal::priority;
  const std::uint8_t command = request.action.command;
  if (command != kCommandControlWord && command < 128) return Refusal::command_reserved;
  if (request.action.slaves.empty()) return Refusal::no_slaves;
  if (const Refusal refused = enabling_refused(request.action); refused != Refusal::none) return refused;
  const bool stops = command == kCommandControlWord && !enables(request.action);
  if (stops) replace_enabling(request.action.slaves);  // also when there is no room for it: the safe side
  if (broadcasts_[request.priority].full()) return Refusal::queue_full;
  if (enables(request.action) && (control_words_.failsafe().bits & request.action.slaves.bits) != 0) {
    listener_.command_done(request.id, Outcome::replaced);
    return Refusal::none;
  }
  broadcasts_[request.priority].push({request, last_interval(request.monitoring_time)});
  return Refusal::none;
}

Refusal CommandChannel::cancel(JobId id) noexcept {
  const auto is = [id](const auto& waiting) { return waiting.request.id == id; };
  const auto is_job = [id](const auto& job) { return job.request().id == id; };
  // What was handed over is on its way; it ends by its echo.
  bool found = false;
  const auto cancelled = [&](JobId ended) {
    listener_.command_done(ended, outcome_of(JobKnown::not_sent, JobEnd::cancelled));
    found = true;
  };
  control_words_.remove_if(is, cancelled);
  for (auto& queue : broadcasts_) {
    queue.remove_each(is, [&](const auto& waiting) { cancelled(waiting.request.id); });
  }
  if (found) return Refusal::none;
  const bool parameter = parameters_.remove_if(is_job, true, [this](ParameterJob& job) {
    if (asked_.kind == Kind::parameter && parameters_.front(asked_.slave) == &job) asked_.kind = Kind::none;
    job.end(JobEnd::cancelled, now_);
    note_late_answer(job);
    listener_.parameter_done(job.request().id, job.result());
  });
  if (parameter) return Refusal::none;
  const bool waiting = transfers_.remove_if(is_job, false, [this](TransferJob& job) {
    job.end(JobEnd::cancelled, now_);
    end_transfer(job);
  });
  if (waiting) return Refusal::none;
  for (const SlaveNumber slave : transfers_.waiting()) {
    TransferJob& job = *transfers_.front(slave);
    if (job.request().id != id) continue;
    if (asked_.kind == Kind::transfer && asked_.slave == slave) asked_.kind = Kind::none;
    if (job.cancel(now_) == Step::ended) finish_transfer(slave);
    return Refusal::none;
  }
  return Refusal::unknown_job;
}

/// Ends what is open for a slave that is gone; how many jobs there were. Control words that stop it stay.
unsigned CommandChannel::end_jobs(SlaveNumber slave) noexcept {
  unsigned ended = 0;
  const auto its_enabling = [&](const ControlWords::Word& word) {
    return word.request.slave == slave && enables(action_of(word.request));
  };
  control_words_.remove_if(its_enabling, [&](JobId id) {
    listener_.command_done(id, outcome_of(JobKnown::not_sent, JobEnd::lost));
    ++ended;
  });
  for (; ParameterJob* job = parameters_.front(slave); ++ended) {
    job->end(JobEnd::lost, now_);
    finish_parameter(slave);
  }
  for (; TransferJob* job = transfers_.front(slave); ++ended) {
    job->slave_lost(now_);
    finish_transfer(slave);
  }
  if (settings_.cancel_at_start) open_transfers_.forget(SlaveMask::of(slave));
  return ended;
}

void CommandChannel::end_all() noexcept {
  const Outcome outcome = outcome_of(JobKnown::not_sent, JobEnd::stopped);
  chosen_.kind = Kind::none;
  asked_.kind = Kind::none;
  sends_sub_slave_ = {};
  settle_echo(outcome_of(JobKnown::handed_over, JobEnd::stopped));
  for (auto& queue : broadcasts_) {
    for (; !queue.empty(); queue.pop()) listener_.command_done(queue.front().request.id, outcome);
  }
  control_words_.remove_if([](const auto&) { return true; },
                           [&](JobId id) { listener_.command_done(id, outcome); });
  stopped_in_a_row_ = {};
  stops_gave_way_ = false;
  for (const SlaveNumber slave : SlaveMask::all()) {
    for (ParameterJob* job = parameters_.front(slave); job != nullptr; job = parameters_.front(slave)) {
      job->end(JobEnd::stopped, now_);
      finish_parameter(slave);
    }
    for (TransferJob* job = transfers_.front(slave); job != nullptr; job = transfers_.front(slave)) {
      job->end(JobEnd::stopped, now_);
      finish_transfer(slave);
    }
  }
}

}  // namespace cansync
