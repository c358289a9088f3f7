#pragma once

#include <cstdint>

#include "cansync/channel/jobs.h"
#include "cansync/channel/outcome_rules.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// For so many intervals an answer to an earlier telegram may still come: late by an interval, and one more.
inline constexpr IntervalNumber kLateIntervals = 3;

/// What an answer, or its absence, means for a job.
enum class Step : std::uint8_t {
  ignored,  ///< not the answer to what was asked; the job still waits
  again,    ///< a telegram is to be sent in a later interval
  ended,    ///< the result is final
};

/// One parameter job on its way: what to send, and what the answers mean (M 3.2.1.3, 3.2.2.6). Pure state
/// machine, realtime safe.
class ParameterJob {
 public:
  ParameterJob() = default;
  /// A job that was not sent yet. The request's ranges must have been checked (`CommandChannel::submit`).
  explicit ParameterJob(const ParameterRequest& request) noexcept;

  /// As it was given; of a default-constructed job an empty one.
  const ParameterRequest& request() const noexcept { return request_; }
  /// The result so far; final after Step::ended or `end`.
  const ParameterResult& result() const noexcept { return result_; }

  /// The telegram to send now. A write "as the slave says" reads first.
  ParameterCommand telegram() const noexcept;

  /// The telegram was handed to the bus in interval `now`.
  void sent(IntervalNumber now) noexcept;

  /// A parameter reply of this slave came in interval `now`. An error answers a write that was sent again after
  /// silence alone: the one before may have been taken, and its answer was lost.
  Step answered(const ParameterReply& reply, IntervalNumber now) noexcept;

  /// No answer came before the next command was chosen. A write ends as `no_answer` unless `repeat_writes`:
  /// the slave may have taken the value, and a value must not be applied twice.
  Step unanswered(bool repeat_writes, IntervalNumber now) noexcept;

  /// Ends the job from outside, as `outcome_of` says for what is known of it.
  void end(JobEnd end, IntervalNumber now) noexcept;

  /// The slave has said that it is busy with the job.
  bool busy() const noexcept { return result_.busy_replies > 0; }

  /// Monitoring time: begins when the job is first of its slave, and ends at this interval.
  bool monitored() const noexcept { return deadline_ != 0; }
  /// Begins the monitoring time; `deadline` over 0. Only noted here: the caller ends the job.
  void monitor_until(IntervalNumber deadline) noexcept { deadline_ = deadline; }
  /// First interval in which the monitoring time is over; 0: it has not begun.
  IntervalNumber deadline() const noexcept { return deadline_; }

 private:
  void end_as(Outcome outcome, IntervalNumber now) noexcept;
  JobKnown known() const noexcept;
  bool reading() const noexcept { return !request_.write || asking_format_; }
  Step take_read(const ParameterReply& reply, IntervalNumber now) noexcept;
  Step take_format(bool doubleword, IntervalNumber now) noexcept;

  ParameterRequest request_;
  ParameterResult result_;
  IntervalNumber first_sent_ = 0;
  IntervalNumber deadline_ = 0;
  bool was_sent_ = false;
  bool write_sent_ = false;   ///< the slave may have the value
  bool write_busy_ = false;   ///< it has the value: it has answered the write with "busy"
  bool asked_again_ = false;  ///< the write was not answered once and sent again, which is another write
  bool asking_format_ = false;
};

}  // namespace cansync
