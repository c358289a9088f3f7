#pragma once

#include <cstdint>
#include <span>

#include "cansync/channel/jobs.h"
#include "cansync/channel/parameter_job.h"
#include "cansync/settings/settings.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// Goes through a list of parameters that a slave must have, because it tells who the slave is or because the
/// slave was away: reads each and compares, or writes each and reads it back. Ends at the first that is not
/// right. Pure state machine, realtime safe.
class ParameterCheck {
 public:
  /// Begins at the first parameter; an empty list is over immediately, and passed. `list` must stay;
  /// `monitoring` is the longest time of each read and write, in intervals.
  void begin(std::span<const ParameterValue> list, bool write, SlaveNumber slave,
             IntervalNumber monitoring) noexcept;
  /// Gives up without a result.
  void stop() noexcept {
    list_ = {};
    sent_ = false;
  }

  /// False: never begun, over, or given up.
  bool running() const noexcept { return !list_.empty(); }

  /// The telegram to send now, while running. Writes are sent again when unanswered: the value is the same.
  ParameterCommand telegram() const noexcept { return job_.telegram(); }
  /// The telegram was handed to the bus.
  void sent(IntervalNumber now) noexcept {
    job_.sent(now);
    sent_ = true;
  }
  /// True: what `telegram` says was sent, and not yet answered. False also when it was given up, or begun anew, since.
  bool waits_for_answer() const noexcept { return sent_; }
  /// A parameter reply of this slave, while `waits_for_answer`. Step::ended: not running any more; see `passed`.
  Step answered(const ParameterReply& reply, IntervalNumber now) noexcept;
  /// To be asked once an interval while running: ends a read or write that takes too long.
  Step check_time(IntervalNumber now) noexcept;

  /// The slave has said that it is busy with the read or write under way.
  bool busy() const noexcept { return running() && job_.busy(); }

  /// After the end: did every parameter have its value?
  bool passed() const noexcept { return failure_ == nullptr; }
  /// Parameters that were right.
  unsigned checked() const noexcept { return at_; }
  /// After a failure: the parameter that was not right, and how reading or writing it ended. Done: it has
  /// another value, `found().value`.
  const ParameterValue& failed() const noexcept { return *failure_; }
  /// Result of the read or write that was last; while running, of the one under way.
  const ParameterResult& found() const noexcept { return job_.result(); }

 private:
  const ParameterValue& wanted() const noexcept { return list_[at_]; }
  void ask(bool write) noexcept;
  Step step_ended() noexcept;

  std::span<const ParameterValue> list_;
  const ParameterValue* failure_ = nullptr;
  bool write_ = false;
  SlaveNumber slave_;
  IntervalNumber monitoring_ = 1;
  unsigned at_ = 0;
  bool sent_ = false;  ///< the telegram of `job_`
  ParameterJob job_;
};

}  // namespace cansync
