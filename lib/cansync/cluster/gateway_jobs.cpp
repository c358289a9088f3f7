#include "cansync/cluster/gateway_jobs.h"

#include <algorithm>
#include <utility>

#include "cansync/channel/outcome_rules.h"
#include "cansync/cluster/gateway_answers.h"

namespace cansync {

// --- parameters

bool GatewayParameter::is_question(const ParameterRequest& request) const noexcept {
  return request.write == question_.write && request.slave == question_.slave &&
         request.sub_slave == question_.sub_slave && request.number == question_.number &&
         request.element == question_.element && request.format == question_.format &&
         request.value == question_.value;
}

ParameterAnswer GatewayParameter::ask(const ParameterRequest& request, Master& lower, JobId& ids) noexcept {
  const bool same = is_question(request);
  if (open_ && !same) drop(lower);
  if (same && remembers()) {
    ++repeated_;
    return *answer_;
  }
  forget_answer();
  asked_ = now_;
  if (open_) {
    if (!answer_) return ParameterAnswer::later();
    open_ = false;
    if (keep_ && times_.remembers_writes) remembered_until_ = now_ + times_.asker_gone;
    return *answer_;
  }
  answer_.reset();
  question_ = request;
  question_.id = ++ids;
  question_.monitoring_time = times_.monitoring;
  const Refusal refused = lower.submit(question_);
  if (refused != Refusal::none) return answer_above_parameter(refused);
  open_ = true;
  job_ = question_.id;
  submitted_ = now_;
  return ParameterAnswer::later();
}

void GatewayParameter::drop(Master& lower) noexcept {
  open_ = false;
  answer_.reset();
  forget_answer();
  // Its end is told within the call, and means nothing any more.
  if (const JobId job = std::exchange(job_, 0); job != 0) static_cast<void>(lower.cancel(job));
}

void GatewayParameter::forget(Master& lower) noexcept {
  drop(lower);
}

void GatewayParameter::sent_below(const ParameterCommand& command) noexcept {
  const bool same = command.slave == question_.slave && command.sub_slave == question_.sub_slave &&
                    command.number == question_.number;
  if (same && command.kind != ParameterCommand::Kind::read) doubt_answer();
}

void GatewayParameter::changed_below(SlaveMask slaves) noexcept {
  if (slaves.has(question_.slave)) doubt_answer();
}

/// "Done" would be untrue for who gives the write again, and a second write for who did not get the answer.
void GatewayParameter::doubt_answer() noexcept {
  if (remembers()) answer_ = ParameterAnswer::refused(ParameterError::unspecified);
}

void GatewayParameter::at(IntervalNumber now, Master& lower) noexcept {
  now_ = now;
  if (open_ && now_ - asked_ > times_.asker_gone) drop(lower);
  // The lower master's own time begins when the job's turn comes. Behind those of others it could be sent
  // when the asker has been told that it failed.
  if (job_ != 0 && now_ - submitted_ > times_.longest) static_cast<void>(lower.cancel(job_));
}

void GatewayParameter::done(JobId id, const ParameterResult& result) noexcept {
  if (id != job_) return;
  job_ = 0;
  answer_ = answer_above(question_.write, result);
  // One that a slave has refused may be given again at once.
  keep_ = question_.write && perhaps_written(result);
}

// --- blocks

GatewayBlock::BlockAnswer GatewayBlock::begin(const TransferInitialise& initialise,
                                              const SubSlaveRoute& route, Master& lower,
                                              JobId& ids) noexcept {
  touched_ = now_;
  switch (phase_) {
    case Phase::none:
      break;
    case Phase::fetched: {
      phase_ = Phase::moving;
      BlockAnswer answer;
      answer.length = length_;
      return answer;
    }
    case Phase::failed:
      phase_ = Phase::none;
      return failure_;
    default:
      return BlockAnswer::later();
  }
  if (job_ != 0) return BlockAnswer::later();  // the area is still another's
  direction_ = initialise.direction;
  route_ = route;
  address_ = initialise.address;
  const std::uint16_t asked = initialise.length.value();
  length_ = asked != 0 ? asked : BlockOffset::max;
  if (direction_ == TransferInitialise::Direction::download) {
    phase_ = Phase::moving;
    return {};
  }
  const BlockAnswer answer = submit(lower, ids);
  if (job_ != 0) phase_ = Phase::fetching;
  return answer;
}

/// Busy: the transfer was taken, or may be asked for again.
GatewayBlock::BlockAnswer GatewayBlock::submit(Master& lower, JobId& ids) noexcept {
  TransferRequest request;
  request.id = ++ids;
  request.direction = direction_;
  request.slave = route_.slave;
  request.sub_slave = route_.below;
  request.address = address_;
  request.data = std::span(area_).first(length_);
  request.monitoring_time = times_.block_monitoring / 2;  // the lower master begins a block again once
  const Refusal refused = lower.submit(request);
  if (refused != Refusal::none) return answer_above_transfer(refused);
  job_ = request.id;
  submitted_ = now_;
  return BlockAnswer::later();
}

GatewayBlock::BlockAnswer GatewayBlock::read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept {
  touched_ = now_;
  if (phase_ == Phase::failed) return failure_;
  if (phase_ != Phase::moving || offset + out.size() > length_)
    return BlockAnswer::refused(TransferError::not_possible);
  std::copy_n(area_.begin() + offset, out.size(), out.begin());
  return {};
}

GatewayBlock::BlockAnswer GatewayBlock::write(std::uint16_t offset, std::span<const std::uint8_t> data,
                                              Master& lower, JobId& ids) noexcept {
  touched_ = now_;
  if (phase_ == Phase::failed) return failure_;
  if (phase_ == Phase::sent) return {};
  if (phase_ == Phase::sending) return BlockAnswer::later();
  if (phase_ != Phase::moving || job_ != 0 || offset + data.size() > length_)
    return BlockAnswer::refused(TransferError::not_possible);
  std::ranges::copy(data, area_.begin() + offset);
  if (offset + data.size() < length_) return {};
  const BlockAnswer answer = submit(lower, ids);
  if (job_ != 0) {
    phase_ = Phase::sending;
  } else if (!answer.busy) {
    phase_ = Phase::failed;
    failure_ = answer;
  }
  return answer;
}

void GatewayBlock::end(bool complete, Master& lower) noexcept {
  phase_ = Phase::none;
  if (!complete) cancel(lower);
}

/// The master tells its slave first, so the area is free a little later.
void GatewayBlock::cancel(Master& lower) noexcept {
  if (job_ == 0 || unwanted_) return;
  unwanted_ = true;
  static_cast<void>(lower.cancel(job_));
}

bool GatewayBlock::took_too_long() const noexcept {
  const bool runs = phase_ == Phase::fetching || phase_ == Phase::sending;
  return runs && now_ - submitted_ > times_.longest_block;
}

void GatewayBlock::at(IntervalNumber now, Master& lower) noexcept {
  now_ = now;
  if (phase_ == Phase::none || phase_ == Phase::failed) return;
  if (now_ - touched_ <= times_.transfer_gone && !took_too_long()) return;
  cancel(lower);
  phase_ = Phase::failed;
  failure_ = BlockAnswer::refused(TransferError::cancelled_by_slave);
}

void GatewayBlock::done(JobId id, const TransferResult& result) noexcept {
  if (id != job_) return;
  job_ = 0;
  if (std::exchange(unwanted_, false)) return;
  failure_ = answer_above(result);
  if (failure_.error != TransferError::none) {
    phase_ = Phase::failed;
  } else if (phase_ == Phase::sending) {
    phase_ = Phase::sent;
  } else if (phase_ == Phase::fetching) {
    length_ = static_cast<std::uint16_t>(result.bytes);
    phase_ = Phase::fetched;
  }
}

}  // namespace cansync
