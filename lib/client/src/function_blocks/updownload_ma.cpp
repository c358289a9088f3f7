#include <cansync/function_blocks/updownload_ma.h>

#include <algorithm>
#include <string>
#include <utility>

#include "client/src/function_blocks/slaves.h"

namespace cansync::client::function_blocks {
namespace {

constexpr std::size_t kDoubleword = 4;  // bytes
constexpr TIME kFullPause(100);         // pause after a refusal that passes

// Doublewords lie low byte first (M 3.1.1).
void store(DINT value, std::uint8_t* out) {
  for (std::size_t i = 0; i < kDoubleword; ++i)
    out[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> (8 * i));
}
DINT load(const std::uint8_t* in) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < kDoubleword; ++i) value |= std::uint32_t{in[i]} << (8 * i);
  return static_cast<DINT>(value);
}

}  // namespace

void UPDOWNLOAD_MA::call(Clock::time_point now) {
  switch (enable_.call(x_EN, x_RESET)) {
    case Enable::Act::start:
      return start(now);
    case Enable::Act::proceed:
      return proceed(now);
    case Enable::Act::abort:
      return give_up();
    case Enable::Act::reset:
      give_up();
      return clear();
    case Enable::Act::nothing:
      return;
  }
}

void UPDOWNLOAD_MA::start(Clock::time_point now) {
  clear();
  if (u_LENGTH == 0) return fail(transfer_error::length_zero, 0, "client: u_LENGTH 0; allowed 1..2048");
  if (auto problem = slave_problem(*client_, si_SL_NR))
    return fail(transfer_error::slave, 0, std::move(problem->reason), problem->cause);
  const std::size_t length = std::min<std::size_t>(u_LENGTH, a_DOWNLOAD.size());
  request_ = {};
  request_.download = x_UPDOWN;
  request_.slave = static_cast<std::uint32_t>(number(si_SL_NR));
  request_.address = ud_ADDRESS;
  request_.timeout_ms = milliseconds_of(t_TIME);
  request_.length = static_cast<std::uint32_t>(length * kDoubleword);
  if (x_UPDOWN) {
    request_.data.resize(request_.length);
    for (std::size_t i = 0; i < length; ++i) store(a_DOWNLOAD[i], &request_.data[i * kDoubleword]);
  }
  attempts_left_ = std::max<unsigned>(us_MAX_NR_OF_COMM, 1);
  deadline_ = now + attempts_left_ * TIME(request_.timeout_ms);
  attempt();
}

void UPDOWNLOAD_MA::attempt() {
  --attempts_left_;
  submit();
}

void UPDOWNLOAD_MA::submit() {
  again_.reset();
  job_.emplace(client_->submit(request_));
  x_BUSY = true;
}

void UPDOWNLOAD_MA::proceed(Clock::time_point now) {
  if (again_) {
    if (now >= deadline_) return fail(transfer_error::slave, 0, std::move(error_), cause_);
    if (now < *again_) return;
    submit();
  }
  if (!job_) return;
  if (const std::optional<TransferReply> reply = job_->wait_for(TIME(0))) {
    job_.reset();
    return take(*reply, now);
  }
  if (now < deadline_) return;
  give_up();
  fail(transfer_error::timeout, 0,
       "client: not done within us_MAX_NR_OF_COMM * t_TIME; the job is cancelled");
}

void UPDOWNLOAD_MA::take(const TransferReply& reply, Clock::time_point now) {
  const bool unanswered = reply.code == ReplyCode::timeout || reply.code == ReplyCode::no_answer ||
                          reply.code == ReplyCode::slave_lost;
  if (unanswered && attempts_left_ > 0 && now < deadline_) return attempt();
  if (unanswered) return fail(transfer_error::timeout, 0, describe(reply));
  if (reply.retry() == Retry::soon && now < deadline_) {
    again_ = now + kFullPause;
    cause_ = reply.cause;
    error_ = describe(reply);
    return;
  }
  if (!reply.ok()) {
    fail(transfer_error::slave, reply.error_code, describe(reply), reply.cause);
    x_ERR_SL = reply.error_code != 0;
    return;
  }
  if (!request_.download) {
    const std::size_t length = std::min(reply.data.size() / kDoubleword, a_UPLOAD.size());
    for (std::size_t i = 0; i < length; ++i) a_UPLOAD[i] = load(&reply.data[i * kDoubleword]);
    u_RECEIVED = static_cast<UINT>(length);
    if (reply.data.size() < request_.length)
      return fail(transfer_error::slave, 0,
                  "client: the slave ended the upload after " + std::to_string(reply.data.size()) + " of " +
                      std::to_string(request_.length) + " bytes");
  }
  x_BUSY = false;
  x_OK = true;
  cause_ = RefusalCause::none;
  error_.clear();
  enable_.ended(true);
}

void UPDOWNLOAD_MA::fail(BYTE bits, WORD number, std::string reason, RefusalCause cause) {
  again_.reset();
  x_BUSY = x_OK = false;
  x_ERR = true;
  b_ERR = bits;
  w_ERR_SL = number;
  cause_ = cause;
  error_ = std::move(reason);
  enable_.ended(false);
}

void UPDOWNLOAD_MA::give_up() {
  if (job_) (void)job_->cancel();
  job_.reset();
  again_.reset();
  x_BUSY = false;
}

void UPDOWNLOAD_MA::clear() {
  x_BUSY = x_OK = x_ERR = x_ERR_SL = false;
  b_ERR = 0;
  w_ERR_SL = 0;
  u_RECEIVED = 0;
  cause_ = RefusalCause::none;
  error_.clear();
}

}  // namespace cansync::client::function_blocks
