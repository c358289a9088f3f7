#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/channel/job_ids.h"
#include "cansync/cluster/sub_slaves.h"
#include "cansync/master.h"
#include "cansync/slave/slave.h"

namespace cansync {

/// Times of jobs that go down, in intervals.
struct GatewayTimes {
  Duration monitoring{};             ///< of the job below, from its submission
  IntervalNumber longest = 0;        ///< the same in intervals
  Duration block_monitoring{};       ///< of a block below, from its submission
  IntervalNumber longest_block = 0;  ///< the same in intervals
  IntervalNumber asker_gone = 0;     ///< a job nobody asks about for so long is dropped
  IntervalNumber transfer_gone = 0;  ///< likewise a block
  bool remembers_writes = true;      ///< a write that comes again within `asker_gone` is not another one
};

/// The one parameter job that a gateway has on the lower bus for the master above (M 3.2.3.7: one at a time).
///
/// Each job goes down once and its answer goes up once. A write whose answer was never on the bus comes again as
/// the same telegram: it is answered from memory and not written again until it counts as gone. The memory
/// ends before that when the answer was on the bus, and with any other question, which shows that it came (M
/// 3.2.3.7: one at a time). When the value below may be another, because somebody else writes it or its slave was away, it
/// says that nobody knows. One that was refused is asked below again. Realtime safe; not thread safe.
class GatewayParameter {
 public:
  /// Nothing is open.
  explicit GatewayParameter(const GatewayTimes& times) noexcept : times_(times) {}

  /// The asker's question, for `route`; the answer, busy while the job runs below. `id` is used when the job
  /// is submitted, and told to have been.
  ParameterAnswer ask(const ParameterRequest& request, Master& lower, JobId& ids) noexcept;
  /// The question is not wanted any more: the job below is cancelled.
  void drop(Master& lower) noexcept;
  /// Interval `now` begins.
  void at(IntervalNumber now, Master& lower) noexcept;
  /// A job of the lower bus has ended.
  void done(JobId id, const ParameterResult& result) noexcept;
  /// Drops what is open, and forgets what was answered.
  void forget(Master& lower) noexcept;
  /// The answer given last was on the bus: the same write again is another one.
  void answered() noexcept { forget_answer(); }
  /// The asker has a question that is none for here.
  void asked_else() noexcept { forget_answer(); }
  /// The answer of a write is kept.
  bool remembers() const noexcept { return !open_ && now_ < remembered_until_; }
  /// While an answer is kept: the lower master sends this, for somebody else.
  void sent_below(const ParameterCommand& command) noexcept;
  /// These slaves of the lower bus were away, or are.
  void changed_below(SlaveMask slaves) noexcept;
  /// Writes that were answered from memory since the start.
  std::uint64_t repeated() const noexcept { return repeated_; }
  /// The job that runs below; 0: none does.
  JobId running() const noexcept { return job_; }

 private:
  bool is_question(const ParameterRequest& request) const noexcept;
  void forget_answer() noexcept { remembered_until_ = 0; }
  void doubt_answer() noexcept;

  GatewayTimes times_;
  IntervalNumber now_ = 0;
  IntervalNumber asked_ = 0;               ///< when the question came last
  IntervalNumber submitted_ = 0;           ///< when its job was
  bool open_ = false;                      ///< `question_` waits for its answer
  ParameterRequest question_;              ///< the open one, or the one answered last
  JobId job_ = 0;                          ///< runs below
  std::optional<ParameterAnswer> answer_;  ///< of `question_`
  bool keep_ = false;                      ///< `answer_` is of a write that has perhaps been applied
  IntervalNumber remembered_until_ = 0;    ///< `answer_` of a write was given, and stays until then
  std::uint64_t repeated_ = 0;
};

/// The one block that a gateway has on the lower bus for the master above. A download is taken whole, then
/// goes down as one transfer, and its last telegram is answered busy meanwhile; an upload comes up whole
/// before its begin is allowed. Realtime safe; not thread safe.
class GatewayBlock {
 public:
  using BlockAnswer = SlaveApplication::BlockAnswer;

  /// Nothing is open.
  explicit GatewayBlock(const GatewayTimes& times) noexcept : times_(times) {}

  /// The slave's `begin_block`, for `route`.
  BlockAnswer begin(const TransferInitialise& initialise, const SubSlaveRoute& route, Master& lower,
                    JobId& ids) noexcept;
  /// The slave's `read_block`.
  BlockAnswer read(std::uint16_t offset, std::span<std::uint8_t> out) noexcept;
  /// The slave's `write_block`.
  BlockAnswer write(std::uint16_t offset, std::span<const std::uint8_t> data, Master& lower,
                    JobId& ids) noexcept;
  /// The slave's `end_block`: what is not complete is cancelled below.
  void end(bool complete, Master& lower) noexcept;
  /// Interval `now` begins.
  void at(IntervalNumber now, Master& lower) noexcept;
  /// A transfer of the lower bus has ended.
  void done(JobId id, const TransferResult& result) noexcept;
  /// The transfer that runs below, wanted or not; 0: none does.
  JobId running() const noexcept { return job_; }

 private:
  enum class Phase : std::uint8_t {
    none,
    fetching,  ///< an upload comes up
    fetched,   ///< it is there; the asker has not been told yet
    moving,    ///< telegrams move between the asker and the area
    sending,   ///< a download goes down
    sent,      ///< it is there; the asker has not been told yet
    failed,    ///< `failure_` has to be told
  };

  BlockAnswer submit(Master& lower, JobId& ids) noexcept;
  bool took_too_long() const noexcept;
  void cancel(Master& lower) noexcept;

  GatewayTimes times_;
  IntervalNumber now_ = 0;
  IntervalNumber touched_ = 0;
  IntervalNumber submitted_ = 0;  ///< when `job_` was
  Phase phase_ = Phase::none;
  TransferInitialise::Direction direction_ = TransferInitialise::Direction::upload;
  SubSlaveRoute route_;
  std::uint32_t address_ = 0;
  std::uint16_t length_ = 0;
  BlockAnswer failure_;
  JobId job_ = 0;          ///< runs below, and owns the area
  bool unwanted_ = false;  ///< its end is waited for, for the area's sake
  std::array<std::uint8_t, BlockOffset::max> area_ = {};
};

}  // namespace cansync
