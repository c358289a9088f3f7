#include <cansync/function_blocks/parameter_block.h>

#include <algorithm>
#include <utility>

#include "client/src/function_blocks/slaves.h"

namespace cansync::client::function_blocks {
namespace {

/// The bit by which the manual would tell it.
BYTE bits_of(RefusalCause cause) noexcept {
  switch (cause) {
    case RefusalCause::slave_not_configured:
      return parameter_error::invalid_slave;
    case RefusalCause::slave_lost:
      return parameter_error::timeout;
    default:
      return parameter_error::communication;
  }
}

}  // namespace

std::optional<ParameterReply> ParameterBlock::step(bool write, UDINT value, Clock::time_point now) {
  switch (enable_.call(x_EN, x_RESET)) {
    case Enable::Act::start:
      start(write, value, now);
      break;
    case Enable::Act::proceed:
      return proceed(now);
    case Enable::Act::abort:
      give_up();
      break;
    case Enable::Act::reset:
      give_up();
      clear();
      break;
    case Enable::Act::nothing:
      break;
  }
  return std::nullopt;
}

void ParameterBlock::start(bool write, UDINT value, Clock::time_point now) {
  clear();
  write_ = write;
  if (auto problem = slave_problem(*client_, si_SL_NR))
    return fail(parameter_error::invalid_slave, 0, std::move(problem->reason), problem->cause);
  ParameterRequest request;
  request.write = write;
  request.slave = static_cast<std::uint32_t>(number(si_SL_NR));
  request.number = u_PAR_NR;
  request.value = value;
  request.sub_slave = static_cast<std::uint16_t>(i_SUB_SL);
  request.format = x_PAR_FORMAT ? ParameterFormat::doubleword : ParameterFormat::word;
  request.timeout_ms = milliseconds_of(t_TIME);
  deadline_ = now + TIME(request.timeout_ms);
  job_.emplace(client_->submit(request));
  x_BUSY = true;
}

std::optional<ParameterReply> ParameterBlock::proceed(Clock::time_point now) {
  if (!job_) return std::nullopt;
  std::optional<ParameterReply> reply = job_->wait_for(TIME(0));
  if (!reply) {
    if (now < deadline_) return std::nullopt;
    give_up();
    fail(parameter_error::timeout, 0,
         "client: not done within t_TIME; the job is cancelled" +
             std::string(write_ ? ", whether the slave took the value is not known" : ""));
    return std::nullopt;
  }
  job_.reset();
  x_BUSY = false;
  if (!reply->ok()) {
    take_error(*reply);
    return std::nullopt;
  }
  x_OK = true;
  enable_.ended(true);
  return reply;
}

void ParameterBlock::take_error(const ParameterReply& reply) {
  switch (reply.code) {
    case ReplyCode::refused:
      return fail(bits_of(reply.cause), 0, describe(reply), reply.cause);
    case ReplyCode::timeout:
    case ReplyCode::no_answer:
    case ReplyCode::slave_lost:
      return fail(parameter_error::timeout, 0, describe(reply));
    case ReplyCode::doubleword_expected:
      return fail(parameter_error::doubleword_expected, 0, describe(reply));
    case ReplyCode::word_expected:
      return fail(parameter_error::word_expected, 0, describe(reply));
    default:
      return fail(parameter_error::communication, static_cast<INT>(reply.error_code), describe(reply));
  }
}

void ParameterBlock::fail(BYTE bits, INT number, std::string reason, RefusalCause cause) {
  x_BUSY = false;
  x_OK = false;
  x_ERR = true;
  b_ERR = bits;
  i_ERR = number;
  cause_ = cause;
  error_ = std::move(reason);
  enable_.ended(false);
}

void ParameterBlock::give_up() {
  if (job_) (void)job_->cancel();
  job_.reset();
  x_BUSY = false;
}

void ParameterBlock::clear() {
  x_BUSY = x_OK = x_ERR = false;
  b_ERR = 0;
  i_ERR = 0;
  cause_ = RefusalCause::none;
  error_.clear();
}

}  // namespace cansync::client::function_blocks
