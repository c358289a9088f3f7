#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "cansync/channel/control_words.h"
#include "cansync/channel/jobs.h"
#include "cansync/channel/open_transfers.h"
#include "cansync/channel/parameter_job.h"
#include "cansync/channel/slave_queues.h"
#include "cansync/channel/transfer_job.h"
#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "cansync/supervision/supervision.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// A first-in-first-out queue of fixed size.
template <class T>
class FixedQueue {
 public:
  /// Takes the memory for `capacity` items, the only function that allocates. Throws std::bad_alloc.
  explicit FixedQueue(std::size_t capacity) : items_(capacity) {}
  /// True when `push` would refuse an item.
  bool full() const noexcept { return count_ == items_.size(); }
  /// True when there is nothing that `front` and `pop` could work on.
  bool empty() const noexcept { return count_ == 0; }
  /// The oldest item. Not allowed when `empty`; lives until the next change.
  const T& front() const noexcept { return items_[first_]; }
  /// Puts a copy behind the others; false, and nothing is changed, when the queue is full.
  bool push(const T& item) noexcept {
    if (full()) return false;
    items_[(first_ + count_) % items_.size()] = item;
    ++count_;
    return true;
  }
  /// Takes the oldest item out. Not allowed when `empty`.
  void pop() noexcept {
    first_ = (first_ + 1) % items_.size();
    --count_;
  }
  /// Takes out every item for which `match` holds and calls `gone` with it; how many there were.
  template <class Match, class Gone>
  std::size_t remove_each(Match match, Gone gone) noexcept {
    const std::size_t before = std::exchange(count_, 0);
    for (std::size_t i = 0; i < before; ++i) {
      const T item = items_[(first_ + i) % items_.size()];
      if (match(item)) {
        gone(item);
      } else {
        push(item);
      }
    }
    return before - count_;
  }

 private:
  std::vector<T> items_;
  std::size_t first_ = 0;
  std::size_t count_ = 0;
};

/// Decides which one command goes out in an interval, and brings the answers to their jobs (M 3.2.2.6).
///
/// Order: broadcast 0; control words that stop; then status words, parameters and transfers whose minimum
/// share is due, longest waiting first; broadcast 1; broadcast 2; control words that enable; parameter;
/// transfer; lists of parameters of slaves that were away; status words. In start-up the activation and the
/// first status words go right after words that stop; then to each slave that answers the telegram that
/// cancels what another master may have left open.
///
/// Control words that stop are those that do not have all enabling bits, and those of the failsafe reaction.
/// They wait for no cursor. Those of several slaves go one an interval, in the order in which they were
/// given. Before a second one in a row of the same slave one other command may go, and before each one
/// broadcast 0, but never two. So a word that waits alone is sent in the next interval but one at the latest,
/// whatever else waits, and one given after n - 1 others within 2n intervals, n + 1 when no broadcast 0 is
/// given, whatever is given later; an interval in which the command is left out comes on top of it. A stop
/// also ends as `replaced` what was given before it and would enable its slaves after it. Broadcasts that
/// stop keep their place among those of their priority.
///
/// Memory is taken in the constructor; everything else is realtime safe. Not thread safe.
class CommandChannel {
 public:
  /// All three must outlive the channel; `settings` must have passed `check` (settings_check.h). Throws
  /// std::bad_alloc.
  CommandChannel(const MasterSettings& settings, Supervision& supervision, MasterListener& listener);

  /// Takes a request; its end is told to the listener under the request's id, for a command that is replaced
  /// at once within this call. A refusal says why it was not taken: the caller corrects the request, or waits
  /// (`queue_full`, `slave_lost`, `slave_held`). Whether the state of the master allows it is the caller's
  /// part. A broadcast that stops ends what would enable its slaves also when there is no room for it.
  Refusal submit(const ParameterRequest& request) noexcept;
  Refusal submit(const TransferRequest& request) noexcept;
  Refusal submit(const ControlWordRequest& request) noexcept;
  Refusal submit(const BroadcastRequest& request) noexcept;
  /// Ends a job as `cancelled`, a running transfer once its slave was told. `unknown_job`: it is not open, or
  /// is a control word or broadcast that was handed over, which ends by its echo.
  Refusal cancel(JobId id) noexcept;

  /// Synchronous operation begins.
  void begin() noexcept;
  /// Nothing can be sent or received: what the slaves have open is not known, except for running transfers.
  void bus_lost() noexcept;

  /// Ends every open job.
  void end_all() noexcept;

  /// A new interval: scanning cursors rise.
  void begin_interval(IntervalNumber now) noexcept;
  /// An interval in which nothing is sent.
  void pass_interval(IntervalNumber now) noexcept { now_ = now; }

  /// The command for this interval. What the last command asked is over: without an answer it counts as
  /// unanswered.
  std::optional<Telegram> take() noexcept;
  /// The telegram of `take` was handed to the bus: its answer or its echo is waited for from here on.
  void sent() noexcept;
  /// The telegram of `take` was not handed over: its job stays where it was and is chosen anew.
  void left_out() noexcept;

  /// End of the last command on the bus, as a time since the start of the timeline.
  void transmitted(Duration end) noexcept;

  /// Answers, with the end of the frame as a time since the start of the timeline. False: nobody asked.
  bool receive(const ParameterReply& reply, Duration end) noexcept;
  bool receive(const TransferReply& reply, Duration end) noexcept;

  /// The slave whose answer is waited for.
  std::optional<SlaveNumber> asked() const noexcept {
    return asked_.kind != Kind::none ? std::optional(asked_.slave) : std::nullopt;
  }

  /// True for what would answer the command that was sent last, whether it was answered or not.
  bool fits_last(const Telegram& reply) const noexcept;

  /// Which slaves each kind of job serves, from the next choice on (M 4.6). `slave_not_configured`: a fixed
  /// slave is not, and all three cursors stay.
  Refusal set_cursors(const Cursor& control_word, const Cursor& parameter, const Cursor& transfer) noexcept;
  /// Automatic cursors rise up to this slave and begin again at 0 (M 4.6).
  void set_maximum_slave(SlaveNumber slave) noexcept { maximum_slave_ = slave; }

  /// The settings of the constructor, with the cursors in force.
  const CommandChannelSettings& settings() const noexcept { return settings_; }
  /// Waiting and running ones of all slaves, 0..`parameter_queue`.
  std::size_t open_parameter_jobs() const noexcept { return parameters_.size(); }
  /// Waiting and running ones of all slaves, 0..`transfer_queue`.
  std::size_t open_transfers() const noexcept { return transfers_.size(); }

 private:
  enum class Kind : std::uint8_t {
    none,
    broadcast,
    control_word,
    parameter,
    transfer,
    cancel,  ///< of a transfer that is not ours
    check,   ///< of the list of a slave that was away, or is not known yet
    census,  ///< of a number that is not configured
    supervision,
  };

  struct Chosen {
    Kind kind = Kind::none;
    SlaveNumber slave;
    std::uint8_t priority = 0;  ///< of a broadcast
    Telegram telegram;
  };

  /// A broadcast that waits, and the interval in which it may be sent last.
  struct WaitingBroadcast {
    BroadcastRequest request;
    IntervalNumber last = 0;
  };

  /// Where a job kind looks for its next slave.
  struct Scan {
    Cursor cursor;
    std::uint8_t rising = 0;          ///< scan: the slave of this interval
    std::uint8_t last = kSlaves - 1;  ///< work conserving: the slave served last
    std::uint32_t passed_over = 0;    ///< intervals in a row in which a waiting job was not served
  };

  std::optional<SlaveNumber> next_slave(const Scan& scan, SlaveMask waiting) const noexcept;
  std::optional<SlaveNumber> next_in_turn(const Scan& scan, SlaveMask waiting) const noexcept;
  bool share_due(const Scan& scan, SlaveMask waiting) const noexcept;
  void count_share(Scan& scan, SlaveMask waiting, bool served) noexcept;
  /// Counts this interval for every kind; `served`: whose command was sent.
  void count_shares(Kind served) noexcept;

  SlaveMask pressing() const noexcept;
  void choose() noexcept;
  bool choose_broadcast(std::uint8_t priority) noexcept;
  bool choose_due_share() noexcept;
  bool choose_stop(SlaveMask giving_way) noexcept;
  bool choose_control_word() noexcept;
  bool choose_word_of(SlaveNumber slave) noexcept;
  bool choose_parameter() noexcept;
  bool choose_transfer() noexcept;
  bool choose_cancel() noexcept;
  bool choose_check() noexcept;
  bool choose_census() noexcept;
  bool choose_supervision() noexcept;

  SlaveMask transfers_waiting() const noexcept;
  void note_late_cancel(const Chosen& asked) noexcept;
  SlaveMask late_answer_may_come() const noexcept;
  void note_late_answer(const ParameterJob& job) noexcept;
  SlaveMask busy_with_a_job() const noexcept;
  bool enables(const ActionCommand& action) const noexcept;
  static ActionCommand action_of(const ControlWordRequest& request) noexcept;
  static ActionCommand action_of(const BroadcastRequest& request) noexcept { return request.action; }
  static bool is_failsafe(const ControlWordRequest& request) noexcept { return request.failsafe; }
  static bool is_failsafe(const BroadcastRequest& /*request*/) noexcept { return false; }
  static Outcome ended_by(Refusal refused) noexcept;
  IntervalNumber last_interval(Duration monitoring_time) const noexcept;
  void replace_enabling(SlaveMask slaves) noexcept;
  Refusal enabling_refused(const ActionCommand& action) const noexcept;
  unsigned end_jobs(SlaveNumber slave) noexcept;
  bool belongs_to_a_write(const ParameterReply& reply) noexcept;
  void settle_unanswered() noexcept;
  void settle_echo(Outcome outcome) noexcept;
  void check_times() noexcept;
  void check_words() noexcept;
  std::optional<Duration> note_response(SlaveNumber slave, Duration end, unsigned data_bytes) noexcept;
  void finish_parameter(SlaveNumber slave) noexcept;
  void finish_transfer(SlaveNumber slave) noexcept;
  void end_transfer(const TransferJob& job) noexcept;
  IntervalNumber intervals(Duration time) const noexcept;

  const MasterSettings& master_;
  CommandChannelSettings settings_;
  Supervision& supervision_;
  MasterListener& listener_;
  SlaveMask configured_;
  SlaveMask sends_sub_slave_;  ///< sent the sub-slave address along since synchronous operation began
  SlaveNumber maximum_slave_;
  std::array<FixedQueue<WaitingBroadcast>, 3> broadcasts_;
  ControlWords control_words_;
  SlaveMask stopped_in_a_row_;    ///< their words that stop went out since another command did
  bool stops_gave_way_ = false;   ///< another command went out while a word that stops waited
  std::optional<JobId> echo_of_;  ///< control word or broadcast handed over, not yet seen on the bus
  SlaveQueues<ParameterJob> parameters_;
  /// A write that ended without its answer: until when that may still come.
  struct LateAnswer {
    ParameterNumber number;
    IntervalNumber until = 0;
  };
  std::array<LateAnswer, kSlaves> late_answers_;
  std::array<IntervalNumber, kSlaves> late_cancels_ =
      {};  ///< until when the answer to a cancel telegram may come
  SlaveQueues<TransferJob> transfers_;
  Scan control_word_scan_;
  Scan parameter_scan_;
  Scan transfer_scan_;
  Scan check_scan_;
  Scan supervision_scan_;          ///< only its share counts
  bool census_gives_way_ = false;  ///< the last command was one, and status words come first
  OpenTransfers open_transfers_;
  Chosen chosen_;
  Chosen asked_;  ///< the last command sent, while its answer may come
  Duration command_end_{-1};
  IntervalNumber now_ = 0;
};

}  // namespace cansync
