#include <algorithm>

#include "cansync/command_channel.h"

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
  for (unsigned number = 0; number < kSlaves; ++number) {
    const SlaveNumber slave = *SlaveNumber::from(number);
    const TransferJob* job = transfers_.front(slave);
    if (job != nullptr && job->on_slave()) slaves.set(slave, false);
  }
  open_transfers_.forget(slaves);
}

/// True for a control word that would enable a slave that is held out.
bool CommandChannel::enables(std::uint16_t control_word) const noexcept {
  const std::uint16_t bits = master_.startup.enabling_control_bits;
  return bits != 0 && (control_word & bits) == bits;
}

/// Why this control word, which enables drives, is not for one of its slaves now. What stops a drive
/// passes always, also to one whose answers do not come.
Refusal CommandChannel::enabling_refused(const ActionCommand& action) const noexcept {
  if (action.command != kCommandControlWord || !enables(action.data_word)) return Refusal::none;
  if ((action.slaves.bits & supervision_.given_up().bits) != 0) return Refusal::slave_lost;
  if ((action.slaves.bits & supervision_.held_out().bits) != 0) return Refusal::slave_held;
  return Refusal::none;
}

Refusal CommandChannel::submit(const ParameterRequest& request) noexcept {
  if (!configured_.has(request.slave)) return Refusal::slave_not_configured;
  if (supervision_.given_up().has(request.slave)) return Refusal::slave_lost;
  if (request.write && request.element != kValueElement) return Refusal::element_not_writable;
  if (request.write && request.format == ParameterFormat::word && request.value > 0xFFFF) {
    return Refusal::value_too_wide;
  }
  return parameters_.push(request.slave, ParameterJob(request)) != nullptr ? Refusal::none
                                                                           : Refusal::queue_full;
}

Refusal CommandChannel::submit(const TransferRequest& request) noexcept {
  if (!configured_.has(request.slave)) return Refusal::slave_not_configured;
  if (supervision_.given_up().has(request.slave)) return Refusal::slave_lost;
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
  const ActionCommand action{SlaveMask::of(request.slave), kCommandControlWord, 0, request.control_word};
  if (const Refusal refused = enabling_refused(action); refused != Refusal::none) return refused;
  if (!control_words_[request.slave.value()].push(request)) return Refusal::queue_full;
  control_words_waiting_.set(request.slave);
  return Refusal::none;
}

Refusal CommandChannel::submit(const BroadcastRequest& request) noexcept {
  if (request.priority > 2) return Refusal::priority;
  const std::uint8_t command = request.action.command;
  if (command != kCommandControlWord && command < 128) return Refusal::command_reserved;
  if (request.action.slaves.empty()) return Refusal::no_slaves;
  if (const Refusal refused = enabling_refused(request.action); refused != Refusal::none) return refused;
  return broadcasts_[request.priority].push(request) ? Refusal::none : Refusal::queue_full;
}

Refusal CommandChannel::cancel(JobId id) noexcept {
  const auto is = [id](const auto& item) { return item.id == id; };
  const auto is_job = [id](const auto& job) { return job.request().id == id; };
  // What was taken for this interval's slot is on its way; it ends as sent.
  for (auto& queue : broadcasts_) {
    if (!queue.remove_if(is)) continue;
    listener_.command_done(id, Outcome::cancelled);
    return Refusal::none;
  }
  for (std::uint8_t slave = 0; slave < kSlaves; ++slave) {
    if (!control_words_[slave].remove_if(is)) continue;
    control_words_waiting_.set(*SlaveNumber::from(slave), !control_words_[slave].empty());
    listener_.command_done(id, Outcome::cancelled);
    return Refusal::none;
  }
  const bool parameter = parameters_.remove_if(is_job, true, [this](ParameterJob& job) {
    if (asked_.kind == Kind::parameter && parameters_.front(asked_.slave) == &job) asked_.kind = Kind::none;
    job.end(Outcome::cancelled, now_);
    listener_.parameter_done(job.request().id, job.result());
  });
  if (parameter) return Refusal::none;
  const bool waiting = transfers_.remove_if(is_job, false, [this](TransferJob& job) {
    job.end(Outcome::cancelled, now_);
    end_transfer(job);
  });
  if (waiting) return Refusal::none;
  for (std::uint32_t left = transfers_.waiting().bits; left != 0; left &= left - 1) {
    const SlaveNumber slave = *SlaveNumber::from(static_cast<unsigned>(__builtin_ctz(left)));
    TransferJob& job = *transfers_.front(slave);
    if (job.request().id != id) continue;
    if (asked_.kind == Kind::transfer && asked_.slave == slave) asked_.kind = Kind::none;
    if (job.abort(Outcome::cancelled, now_) == Step::ended) finish_transfer(slave);
    return Refusal::none;
  }
  return Refusal::unknown_job;
}

/// Ends what is open for a slave that is gone; how many jobs there were. Control words that stop it stay.
unsigned CommandChannel::end_jobs(SlaveNumber slave) noexcept {
  unsigned ended = 0;
  auto& words = control_words_[slave.value()];
  const auto end_enabling = [this](const ControlWordRequest& request) {
    if (!enables(request.control_word)) return false;
    listener_.command_done(request.id, Outcome::slave_lost);
    return true;
  };
  while (words.remove_if(end_enabling)) ++ended;
  control_words_waiting_.set(slave, !words.empty());
  for (; ParameterJob* job = parameters_.front(slave); ++ended) {
    job->slave_lost(now_);
    finish_parameter(slave);
  }
  for (; TransferJob* job = transfers_.front(slave); ++ended) {
    job->slave_lost(now_);
    finish_transfer(slave);
  }
  if (settings_.cancel_at_start) open_transfers_.forget(SlaveMask::of(slave));
  return ended;
}

void CommandChannel::end_all(Outcome outcome) noexcept {
  chosen_.kind = Kind::none;
  asked_.kind = Kind::none;
  sends_sub_slave_ = {};
  for (auto& queue : broadcasts_) {
    for (; !queue.empty(); queue.pop()) listener_.command_done(queue.front().id, outcome);
  }
  for (auto& queue : control_words_) {
    for (; !queue.empty(); queue.pop()) listener_.command_done(queue.front().id, outcome);
  }
  control_words_waiting_ = {};
  for (unsigned number = 0; number < kSlaves; ++number) {
    const SlaveNumber slave = *SlaveNumber::from(number);
    for (ParameterJob* job = parameters_.front(slave); job != nullptr; job = parameters_.front(slave)) {
      job->end(outcome, now_);
      finish_parameter(slave);
    }
    for (TransferJob* job = transfers_.front(slave); job != nullptr; job = transfers_.front(slave)) {
      job->end(outcome, now_);
      finish_transfer(slave);
    }
  }
}

}  // namespace cansync
