#include "cansync/channel/transfer_job.h"

#include <algorithm>

#include "cansync/telegram/reply_payload.h"

namespace cansync {
namespace {

/// Errors about the order of telegrams may pass when the telegram or the block is sent again; the others are
/// answers.
bool about_order(TransferError error) noexcept {
  switch (error) {
    case TransferError::wrong_block_acknowledged:
    case TransferError::other_block_expected:
    case TransferError::end_expected:
    case TransferError::end_not_expected:
    case TransferError::mode_not_allowed:
      return true;
    default:
      return false;
  }
}

}  // namespace

TransferJob::TransferJob(const TransferRequest& request, const TransferLimits& limits) noexcept
    : request_(request), limits_(limits) {
  begin_block();
}

void TransferJob::begin_block() noexcept {
  block_length_ =
      static_cast<std::uint16_t>(std::min<std::uint32_t>(limits_.block_size, total() - block_start_));
  ends_here_ = false;
  go_on_at(0);
  on_slave_ = false;
}

void TransferJob::go_on_at(std::uint16_t offset) noexcept {
  offset_ = offset;
  refusals_ = 0;
  silence_ = false;
}

Telegram TransferJob::telegram() const noexcept {
  const SlaveNumber slave = request_.slave;
  if (phase_ == TransferPhase::cancel) return cancel_transfer(slave);
  if (phase_ == TransferPhase::initialise) {
    const std::uint32_t address = request_.address + block_start_ / limits_.address_step;
    return TransferInitialise{slave, request_.direction, *BlockOffset::from(block_length_), address,
                              request_.sub_slave};
  }
  const BlockOffset offset = *BlockOffset::from(offset_);
  if (request_.direction == TransferRequest::Direction::upload) return UploadBlock{slave, offset, last()};
  DownloadBlock block{slave, offset, last(), {}};
  const std::size_t bytes = std::min<std::size_t>(6, block_length_ - offset_);
  const auto data = request_.data.subspan(block_start_ + offset_, bytes);
  std::copy(data.begin(), data.end(), block.data.begin());
  return block;
}

void TransferJob::sent(IntervalNumber now) noexcept {
  if (!was_sent_) first_sent_ = now;
  was_sent_ = true;
  if (phase_ != TransferPhase::cancel) on_slave_ = true;
  if (phase_ == TransferPhase::body && request_.direction == TransferRequest::Direction::download)
    data_sent_ = true;
}

JobKnown TransferJob::known() const noexcept {
  return data_sent_ ? JobKnown::handed_over : JobKnown::not_sent;
}

void TransferJob::end(JobEnd end, IntervalNumber now) noexcept {
  end_as(outcome_of(known(), end), now);
}

Step TransferJob::cancel(IntervalNumber now) noexcept {
  return abort(outcome_of(known(), JobEnd::cancelled), now);
}

void TransferJob::end_as(Outcome outcome, IntervalNumber now) noexcept {
  left_open_ = phase_ == TransferPhase::cancel && !told_;
  take(TransferEvent::ended);
  result_.outcome = outcome;
  result_.intervals =
      was_sent_ ? static_cast<std::uint32_t>(std::max<IntervalNumber>(now - first_sent_, 1)) : 0;
}

void TransferJob::slave_lost(IntervalNumber now) noexcept {
  result_.bytes = block_start_;
  result_.error_offset = block_start_ + offset_;
  end(JobEnd::lost, now);
}

Step TransferJob::answered(const TransferReply& reply, IntervalNumber now) noexcept {
  if (reply.busy) return Step::again;
  if (phase_ == TransferPhase::cancel) {
    told_ = true;
    return cancelled(now);
  }
  if (reply.error) {
    const TransferError error = error_answer(reply).value_or(TransferError::none);
    if (silence_ && about_order(error)) return refused_after_silence(error, reply.offset, now);
    return refused(error, now);
  }
  return phase_ == TransferPhase::initialise ? initialised(reply, now) : block_answered(reply, now);
}

Step TransferJob::initialised(const TransferReply& reply, IntervalNumber now) noexcept {
  if (!is_acknowledgement(reply)) return Step::ignored;
  const std::uint16_t fixed = reply.offset.value();
  if (request_.direction == TransferRequest::Direction::upload && fixed != 0 && fixed != block_length_) {
    if (fixed > total() - block_start_) {
      result_.error = TransferError::block_too_long;
      result_.error_offset = block_start_;
      return fail_block(Outcome::slave_error, false, now);
    }
    ends_here_ = fixed < block_length_;
    block_length_ = fixed;
  }
  // The answer to the first data of a download is the same, and each initialise that was repeated has its own.
  if (silence_ && request_.direction == TransferRequest::Direction::download)
    not_before_ = now + kLateIntervals;
  take(TransferEvent::accepted);
  go_on_at(0);
  return Step::again;
}

Step TransferJob::block_answered(const TransferReply& reply, IntervalNumber now) noexcept {
  const bool upload = request_.direction == TransferRequest::Direction::upload;
  const auto brought = upload_bytes(reply);
  if (upload ? !brought : !is_acknowledgement(reply)) return Step::ignored;
  if (reply.offset.value() != offset_) return refused(TransferError::wrong_block_acknowledged, now);
  if (upload) {
    const std::ptrdiff_t bytes = std::min<std::ptrdiff_t>(6, block_length_ - offset_);
    std::copy_n(brought->begin(), bytes, request_.data.begin() + block_start_ + offset_);
  }
  return advance(now);
}

Step TransferJob::advance(IntervalNumber now) noexcept {
  if (last()) return block_complete(now);
  take(TransferEvent::bytes_taken);
  go_on_at(static_cast<std::uint16_t>(offset_ + 6));
  result_.bytes = block_start_ + offset_;
  return Step::again;
}

Step TransferJob::block_complete(IntervalNumber now) noexcept {
  block_start_ += block_length_;
  result_.bytes = block_start_;
  retries_ = 0;
  if (block_start_ >= total() || ends_here_) {
    end_as(Outcome::done, now);
    return Step::ended;
  }
  timed_ = false;
  take(TransferEvent::block_done);
  begin_block();
  return Step::again;
}

Step TransferJob::refused(TransferError error, IntervalNumber now) noexcept {
  result_.error_offset = block_start_ + offset_;
  if (about_order(error) && refusals_ < limits_.telegram_repeats) {
    ++refusals_;
    ++result_.repeated_telegrams;
    return Step::again;
  }
  result_.error = error;
  return fail_block(Outcome::slave_error, about_order(error), now);
}

Step TransferJob::refused_after_silence(TransferError error, BlockOffset expected,
                                        IntervalNumber now) noexcept {
  // Not the last one: a slave that refused it has closed the block as well, and what it said was not heard.
  const bool taken = request_.direction == TransferRequest::Direction::download &&
                     phase_ == TransferPhase::body && !last() &&
                     error == TransferError::other_block_expected && expected.value() == offset_ + 6;
  if (taken) return advance(now);
  ++result_.repeated_blocks;
  result_.bytes = block_start_;
  return abort(Outcome::done, now);
}

Step TransferJob::unanswered(IntervalNumber now) noexcept {
  if (phase_ == TransferPhase::cancel) return cancels_++ == 0 ? Step::again : cancelled(now);
  silence_ = true;
  ++result_.repeated_telegrams;
  return Step::again;
}

Step TransferJob::check_time(IntervalNumber now) noexcept {
  if (phase_ == TransferPhase::cancel) return now < cancel_deadline_ ? Step::again : cancelled(now);
  if (!timed_) {
    timed_ = true;
    deadline_ = now + limits_.monitoring;
    return Step::again;
  }
  if (now < deadline_) return Step::again;
  result_.error_offset = block_start_ + offset_;
  return fail_block(outcome_of(known(), JobEnd::time), true, now);
}

Step TransferJob::fail_block(Outcome outcome, bool may_retry, IntervalNumber now) noexcept {
  if (may_retry && retries_ < limits_.block_retries) {
    ++retries_;
    ++result_.repeated_blocks;
    timed_ = false;
    outcome = Outcome::done;
  } else {
    retries_ = limits_.block_retries;
  }
  result_.bytes = block_start_;
  return abort(outcome, now);
}

Step TransferJob::abort(Outcome outcome, IntervalNumber now) noexcept {
  after_cancel_ = outcome;
  if (!on_slave_) return cancelled(now);
  // Cancelled once more while it is told already: that time goes on.
  if (phase_ != TransferPhase::cancel) cancel_deadline_ = now + limits_.cancel_patience;
  take(TransferEvent::given_up);
  not_before_ = 0;
  cancels_ = 0;
  told_ = false;
  return Step::again;
}

Step TransferJob::cancelled(IntervalNumber now) noexcept {
  if (after_cancel_ == Outcome::done) {
    result_.error = TransferError::none;
    const bool may_be_open = on_slave_ && !told_;
    take(TransferEvent::begun_again);
    begin_block();
    silence_ = may_be_open;
    return Step::again;
  }
  end_as(after_cancel_, now);
  return Step::ended;
}

}  // namespace cansync
