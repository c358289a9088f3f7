#pragma once

#include <cstdint>

#include "cansync/channel/jobs.h"
#include "cansync/channel/outcome_rules.h"
#include "cansync/channel/parameter_job.h"
#include "cansync/channel/transfer_phase.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Limits of a transfer that come from the settings.
struct TransferLimits {
  std::uint16_t block_size = 300;      ///< bytes per initialise, 1..4092
  std::uint8_t telegram_repeats = 1;   ///< times a telegram the slave refused is sent again
  std::uint8_t block_retries = 1;      ///< times a failed block is begun again
  std::uint8_t address_step = 1;       ///< bytes per start address
  IntervalNumber monitoring = 30'000;  ///< intervals a block may take
  /// Intervals until a job whose cancel telegram could not be sent, or is answered busy, ends without.
  IntervalNumber cancel_patience = 1'000;
};

/// Longest block one initialise may announce: a multiple of 6 and of 4 that the 12-bit length holds.
inline constexpr std::uint16_t kLongestBlock = 4092;

/// One upload or download on its way: blocks of initialise, body and last telegrams, repeats, cancel
/// (M 3.2.1.3, 4.24). Pure state machine, realtime safe; touches the request's data only.
///
/// A telegram without an answer is sent again, and a slave that took it the first time may refuse it as out
/// of order. A download then goes on where the slave says it stands (0x0100, M 3.2.2.6), when that is the
/// next offset; otherwise the block is begun anew at once, as often as its time allows, beside the block
/// retries.
class TransferJob {
 public:
  TransferJob() = default;
  /// A job that was not sent yet. `request.data` must not be empty and must stay valid until the job's end;
  /// ranges must have been checked (`CommandChannel::submit`).
  TransferJob(const TransferRequest& request, const TransferLimits& limits) noexcept;

  /// As it was given; of a default-constructed job an empty one.
  const TransferRequest& request() const noexcept { return request_; }
  /// The result so far, with the bytes confirmed; final after Step::ended, `end` or `slave_lost`.
  const TransferResult& result() const noexcept { return result_; }

  /// The telegram to send now.
  Telegram telegram() const noexcept;

  /// The telegram was handed to the bus in interval `now`.
  void sent(IntervalNumber now) noexcept;

  /// A transfer reply of this slave came in interval `now`.
  Step answered(const TransferReply& reply, IntervalNumber now) noexcept;

  /// No answer came before the next command was chosen: the telegram is sent again until the block's time is
  /// over.
  Step unanswered(IntervalNumber now) noexcept;

  /// To be asked once an interval while the job is first of its slave: begins the block's monitoring time,
  /// and ends the block when it is over; likewise the time for a cancel telegram.
  Step check_time(IntervalNumber now) noexcept;

  /// Cancels the job: `again` = a cancel telegram is to be sent first.
  Step cancel(IntervalNumber now) noexcept;

  /// Ends the job from outside at once, without a cancel telegram, as `outcome_of` says for what is known of it.
  void end(JobEnd end, IntervalNumber now) noexcept;

  /// Ends the job at once because the slave is gone: what it has of the running block does not count.
  void slave_lost(IntervalNumber now) noexcept;

  /// No telegram of the job is to be sent before this interval: a late answer would be taken for its own.
  IntervalNumber not_before() const noexcept { return not_before_; }

  /// The telegram to send now is the cancel telegram.
  bool cancelling() const noexcept { return phase_ == TransferPhase::cancel; }

  /// True when the job ended without the slave having confirmed the cancel telegram: it may have a block
  /// open.
  bool left_open() const noexcept { return left_open_; }

  /// True when the slave may have a block of this job open.
  bool on_slave() const noexcept { return on_slave_; }

 private:
  std::uint32_t total() const noexcept { return static_cast<std::uint32_t>(request_.data.size()); }
  bool last() const noexcept { return offset_ + 6u >= block_length_; }
  void begin_block() noexcept;
  void go_on_at(std::uint16_t offset) noexcept;
  void take(TransferEvent event) noexcept { phase_ = next(phase_, event).value_or(phase_); }
  Step initialised(const TransferReply& reply, IntervalNumber now) noexcept;
  Step block_answered(const TransferReply& reply, IntervalNumber now) noexcept;
  Step block_complete(IntervalNumber now) noexcept;
  Step advance(IntervalNumber now) noexcept;
  Step refused(TransferError error, IntervalNumber now) noexcept;
  Step refused_after_silence(TransferError error, BlockOffset expected, IntervalNumber now) noexcept;
  Step fail_block(Outcome outcome, bool may_retry, IntervalNumber now) noexcept;
  Step abort(Outcome outcome, IntervalNumber now) noexcept;
  Step cancelled(IntervalNumber now) noexcept;
  void end_as(Outcome outcome, IntervalNumber now) noexcept;
  JobKnown known() const noexcept;

  TransferRequest request_;
  TransferLimits limits_;
  TransferResult result_;
  TransferPhase phase_ = TransferPhase::initialise;  ///< changed by `take` alone
  Outcome after_cancel_ =
      Outcome::done;  ///< how the job ends after the cancel telegram; done = begin the block again
  std::uint32_t block_start_ = 0;
  std::uint16_t block_length_ = 0;
  std::uint16_t offset_ = 0;
  bool ends_here_ = false;  ///< the slave fixed a shorter length for this block: no block follows
  /// This telegram, or the cancel before it, went without an answer: what the slave made of it is not known.
  bool silence_ = false;
  std::uint8_t refusals_ = 0;
  std::uint8_t retries_ = 0;
  std::uint8_t cancels_ = 0;
  IntervalNumber not_before_ = 0;
  bool was_sent_ = false;
  bool data_sent_ = false;  ///< bytes of a download were: the slave may have changed its memory
  bool on_slave_ = false;   ///< an initialise was sent: the slave may have an open block
  bool timed_ = false;
  bool told_ = false;       ///< the slave has answered the cancel telegram
  bool left_open_ = false;  ///< ended in the cancel phase, and the slave had not answered
  IntervalNumber first_sent_ = 0;
  IntervalNumber deadline_ = 0;         ///< of the block, however often it is begun anew after silence
  IntervalNumber cancel_deadline_ = 0;  ///< of the cancel telegram
};

}  // namespace cansync
