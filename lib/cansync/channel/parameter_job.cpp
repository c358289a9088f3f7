#include "cansync/channel/parameter_job.h"

#include <algorithm>

#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

/// True when the sub-slave address of a reply is left out or the one asked.
bool same_sub_slave(std::optional<SubSlave> answered, SubSlave asked) noexcept {
  return answered.value_or(asked) == asked;
}

}  // namespace

ParameterJob::ParameterJob(const ParameterRequest& request) noexcept
    : request_(request), asking_format_(request.write && request.format == ParameterFormat::as_slave_says) {
  result_.doubleword = request.format == ParameterFormat::doubleword;
  if (request.write) result_.value = request.value;
}

ParameterCommand ParameterJob::telegram() const noexcept {
  ParameterCommand command;
  command.slave = request_.slave;
  command.number = request_.number;
  command.element = request_.element;
  command.sub_slave = request_.sub_slave;
  if (!reading()) {
    command.kind =
        result_.doubleword ? ParameterCommand::Kind::write_doubleword : ParameterCommand::Kind::write_word;
    command.value = request_.value;
  }
  return command;
}

void ParameterJob::sent(IntervalNumber now) noexcept {
  if (!was_sent_) first_sent_ = now;
  was_sent_ = true;
  if (!reading()) write_sent_ = true;
}

JobKnown ParameterJob::known() const noexcept {
  if (write_busy_) return JobKnown::taken;
  return write_sent_ ? JobKnown::handed_over : JobKnown::not_sent;
}

void ParameterJob::end(JobEnd end, IntervalNumber now) noexcept {
  end_as(outcome_of(known(), end), now);
}

void ParameterJob::end_as(Outcome outcome, IntervalNumber now) noexcept {
  result_.outcome = outcome;
  const IntervalNumber used = was_sent_ ? std::max<IntervalNumber>(now - first_sent_, 1) : 0;
  result_.intervals = static_cast<std::uint32_t>(used);
}

Step ParameterJob::answered(const ParameterReply& reply, IntervalNumber now) noexcept {
  if (reply.number != request_.number) return Step::ignored;
  if (reply.busy) {
    ++result_.busy_replies;
    if (!reading()) write_busy_ = true;
    return Step::again;
  }
  if (reply.error) {
    const auto answer = error_answer(reply);
    if (!answer || !same_sub_slave(answer->sub_slave, request_.sub_slave)) return Step::ignored;
    if (asked_again_) {
      end(JobEnd::unanswered, now);
      return Step::ended;
    }
    result_.error = answer->error;
    end_as(Outcome::slave_error, now);
    return Step::ended;
  }
  if (reading()) return take_read(reply, now);
  if (!confirms_write(reply) || !same_sub_slave(write_sub_slave(reply), request_.sub_slave)) {
    return Step::ignored;
  }
  end_as(Outcome::done, now);
  return Step::ended;
}

Step ParameterJob::take_read(const ParameterReply& reply, IntervalNumber now) noexcept {
  const auto answer = read_answer(reply);
  if (!answer || !same_sub_slave(answer->sub_slave, request_.sub_slave)) return Step::ignored;
  const bool doubleword = answer->doubleword;
  if (asking_format_) return take_format(doubleword, now);
  result_.doubleword = doubleword;
  result_.value = answer->value;
  const bool wrong = request_.format != ParameterFormat::as_slave_says &&
                     doubleword != (request_.format == ParameterFormat::doubleword);
  const Outcome mismatch = doubleword ? Outcome::doubleword_expected : Outcome::word_expected;
  end_as(wrong ? mismatch : Outcome::done, now);
  return Step::ended;
}

Step ParameterJob::take_format(bool doubleword, IntervalNumber now) noexcept {
  result_.doubleword = doubleword;
  asking_format_ = false;
  if (!doubleword && request_.value > 0xFFFF) {
    end_as(Outcome::value_too_wide, now);
    return Step::ended;
  }
  return Step::again;
}

Step ParameterJob::unanswered(bool repeat_writes, IntervalNumber now) noexcept {
  if (reading()) return Step::again;
  // After a busy reply the slave has the value for certain, and the repeated telegram asks whether it is done.
  if (!repeat_writes && !write_busy_) {
    end(JobEnd::unanswered, now);
    return Step::ended;
  }
  asked_again_ = true;
  return Step::again;
}

}  // namespace cansync
