#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "cansync/master.h"
#include "cansync/settings/settings.h"
#include "cansync/supervision/parameter_check.h"
#include "cansync/supervision/slave_state.h"
#include "cansync/telegram/numbers.h"
#include "cansync/telegram/telegram.h"

namespace cansync {

/// A slave that answers for so long without being synchronized is activated again: it may have missed the
/// activation. Slaves need up to seconds to synchronize (M 3.2.2.3).
inline constexpr Duration kActivateAgain = std::chrono::seconds(5);

/// Knows which slaves respond and are synchronized: sends "SYNC mode: activate", reads status words, counts
/// silence (M 3.2.0.1, 3.2.2.3, 3.2.2.7). Holds a slave out, and does not activate it, until it is known to be
/// the drive expected; and one that was away until it is synchronized and has passed its list of parameters.
/// Realtime safe; not thread safe.
class Supervision {
 public:
  /// Both must outlive this object; `settings` must have passed `check` (settings_check.h).
  Supervision(const MasterSettings& settings, MasterListener& listener) noexcept;

  /// Synchronous operation begins in interval `now`: nothing is known of any slave.
  void begin(IntervalNumber now) noexcept;

  /// A new interval; `active` as in `is_active`.
  void begin_interval(IntervalNumber now, bool active) noexcept {
    now_ = now;
    active_ = active;
  }

  /// True while the activation, or a slave's first status word of this start-up, is still to be sent: goes
  /// before jobs.
  bool urgent() const noexcept { return !may_be_activated().empty() || !first_round_.empty(); }

  /// True while status words should not wait for ever behind jobs: in set-up until all are synchronized that
  /// answer, in active operation when a slave is suspected to be gone or one that is not released is due.
  bool pressing() const noexcept { return !wanted().empty(); }

  /// What supervision wants to send in this interval; nothing when no status word is due. The status words of
  /// `left_alone` wait.
  std::optional<Telegram> telegram(SlaveMask left_alone) noexcept;
  /// The telegram was handed to the bus.
  void sent(const Telegram& telegram) noexcept;

  /// Is this the answer to a status read?
  bool is_answer(const ParameterReply& reply) const noexcept {
    return reply.number.value() == settings_.slaves[reply.slave.value()].status_parameter;
  }
  /// Takes the answer to a status read, after `responded`.
  void answered(const ParameterReply& reply) noexcept;

  /// The status word of a slave came among its actual values. Believed of one that answers commands.
  void came(SlaveNumber slave, std::uint16_t status_word) noexcept;

  /// Any telegram of a slave arrived.
  void seen(SlaveNumber slave) noexcept;
  /// A response that nobody asked for came from this slave: it is there.
  void heard(SlaveNumber slave) noexcept { silence_[slave.value()] = 0; }
  /// A command to this slave got its answer; `response` from the end of the command to the end of the answer.
  void responded(SlaveNumber slave, std::optional<Duration> response, bool slow) noexcept;
  /// A command to this slave got no answer. True: it is given up now. Its jobs are to be ended, then `lost`
  /// called.
  bool silent(SlaveNumber slave) noexcept;
  /// This slave was given up, and so many jobs of it were ended.
  void lost(SlaveNumber slave, unsigned jobs) noexcept;
  /// A slave that was asked for actual values sent none.
  void missed_actual(SlaveNumber slave) noexcept;

  /// Nothing can be sent or received: nothing is known of any slave, and each that answers again is
  /// activated, all of them when none had answered yet. No event for each slave; whoever tells that the bus is gone has said it all.
  void bus_lost() noexcept;

  /// The mask of configured slaves that do not yet meet the enable rule. One that is held out does not.
  SlaveMask missing(EnableRule rule) const noexcept;

  /// Configured slaves that have answered and were not lost since.
  SlaveMask responding() const noexcept { return responding_; }
  /// Slaves that have not answered so often in a row that nothing but status reads is sent to them.
  SlaveMask given_up() const noexcept { return given_up_; }
  /// Slaves that are given up, or lost with the bus and have not answered since: no jobs are for them.
  SlaveMask away() const noexcept { return {given_up_.bits | lost_.bits}; }
  /// Slaves that were away (`is_held_out`), are not known to be the drive expected, or may be two and are not
  /// synchronized: not to be enabled yet.
  SlaveMask held_out() const noexcept {
    return {held_out_.bits | unidentified().bits | (maybe_two().bits & ~synchronized_.bits)};
  }

  // --- the lists of parameters: who a slave is, and what it must have after it was away

  /// Slaves whose list is being gone through: one telegram each at a time, on the command channel.
  SlaveMask checking() const noexcept { return checking_; }
  /// Those of them that are busy with what their list needs.
  SlaveMask busy_with_checks() const noexcept;
  /// The read or write that the slave's list needs next. Only for a slave of `checking`.
  ParameterCommand check_telegram(SlaveNumber slave) const noexcept {
    return checks_[slave.value()].telegram();
  }
  /// The telegram of `check_telegram` was handed to the bus.
  void check_sent(SlaveNumber slave) noexcept { checks_[slave.value()].sent(now_); }
  /// False: not the answer.
  bool check_answered(SlaveNumber slave, const ParameterReply& reply) noexcept;
  /// Ends what takes too long; once an interval.
  void check_times() noexcept;
  /// See `Master::release`.
  Refusal release(SlaveNumber slave, bool force) noexcept;

  // --- two drives of one number, and numbers that are not configured

  /// A question went to this slave, of any kind.
  void asked(SlaveNumber slave) noexcept;
  /// This slave has answered more often than it was asked. Once is no proof: a frame may come twice.
  void answered_twice(SlaveNumber slave) noexcept;
  /// Slaves as which two drives answer.
  SlaveMask duplicates() const noexcept { return duplicates_; }

  /// The next number that is not configured and was not asked yet; nothing when all were.
  std::optional<SlaveNumber> next_of_census() const noexcept {
    return census_.empty() ? std::nullopt : std::optional(*census_.begin());
  }
  /// It was asked.
  void counted(SlaveNumber slave) noexcept { census_.set(slave, false); }
  /// A telegram of this slave came, which may not be configured.
  void came(SlaveNumber slave) noexcept;
  /// Slaves that have sent one since set-up began.
  SlaveMask unknown() const noexcept { return unknown_; }

  /// What is known of a slave, also of one that is not configured; changes with the next call.
  const SlaveStatus& status(SlaveNumber slave) const noexcept { return status_[slave.value()]; }

 private:
  /// How a slave does not give its status word.
  struct StatusRefusal {
    std::optional<IntervalNumber> told;            ///< when last
    std::optional<IntervalNumber> wordless_since;  ///< it answers with neither a word nor an error
    bool wordless_told = false;
  };

  SlaveStatus& at(SlaveNumber slave) noexcept { return status_[slave.value()]; }
  std::optional<SlaveNumber> next_due(SlaveMask left_alone) noexcept;
  bool due(SlaveNumber slave) const noexcept;
  void set_synchronized(SlaveNumber slave, bool synchronized) noexcept;
  void tell(MasterEvent::Code code, std::optional<SlaveNumber> slave, std::uint32_t detail = 0) noexcept;
  SlaveMask wanted() const noexcept;
  bool wanted(SlaveNumber slave) const noexcept;
  IntervalNumber pause(SlaveNumber slave) const noexcept;
  void forget(SlaveNumber slave) noexcept;
  void change(SlaveNumber slave, SlaveEvent event) noexcept;
  void take(SlaveNumber slave, SlaveEvent event) noexcept;
  SlaveMask activated_at_start() const noexcept { return expects_.empty() ? SlaveMask::all() : configured_; }
  SlaveMask unidentified() const noexcept { return {expects_.bits & ~identified_.bits}; }
  SlaveMask maybe_two() const noexcept;
  SlaveMask may_be_activated() const noexcept {
    return {to_activate_.bits & ~(unidentified().bits | maybe_two().bits)};
  }
  void identify(SlaveNumber slave, bool again = false) noexcept;
  void identified(SlaveNumber slave) noexcept;
  void begin_check(SlaveNumber slave, std::span<const ParameterValue> list, bool write) noexcept;
  void forget_evidence(SlaveNumber slave) noexcept;
  bool waits_for_proof(SlaveNumber slave) const noexcept;
  void hold(SlaveNumber slave, SlaveEvent event, const MasterEvent& reason) noexcept;
  void activate(SlaveNumber slave) noexcept;
  void activate_again(SlaveNumber slave) noexcept;
  void synchronized_again(SlaveNumber slave) noexcept;
  void take_status(SlaveNumber slave, std::uint16_t word) noexcept;
  void status_refused(SlaveNumber slave, std::uint16_t code) noexcept;
  void tell_refused(SlaveNumber slave, Outcome outcome) noexcept;
  void end_check(SlaveNumber slave) noexcept;

  const MasterSettings& settings_;
  MasterListener& listener_;
  SlaveMask configured_;
  SlaveMask expects_;              ///< configured slaves that must be a certain drive
  IntervalNumber period_;          ///< between status words of a released slave; 0: never
  IntervalNumber lost_period_;     ///< of a slave that is given up
  IntervalNumber recheck_;         ///< of a slave that is neither
  IntervalNumber monitoring_;      ///< longest time of a read or write of a list
  IntervalNumber activate_again_;  ///< after an activation that did not help
  IntervalNumber refused_again_;   ///< least time between two events of a slave that refuses its status word
  std::array<SlaveStatus, kSlaves> status_ = {};
  std::array<IntervalNumber, kSlaves> next_read_ = {};
  std::array<std::uint8_t, kSlaves> silence_ = {};
  std::array<IntervalNumber, kSlaves> activated_ = {};  ///< when last
  std::array<StatusRefusal, kSlaves> refused_ = {};
  SlaveMask to_activate_;
  SlaveMask first_round_;
  SlaveMask responding_;
  SlaveMask synchronized_;
  SlaveMask suspect_;  ///< did not answer, or sent no actual values when asked, and has not answered since
  SlaveMask given_up_;
  SlaveMask lost_;
  SlaveMask held_out_;
  SlaveMask identified_;  ///< those of `expects_` that are the drive expected, or count as it by command
  SlaveMask
      asked_again_;  ///< asked who they are because the activation did not help; nothing new, unless wrong
  SlaveMask released_;
  SlaveMask checking_;
  SlaveMask doubtful_;                               ///< answered too often, and not yet often enough without
  SlaveMask duplicates_;                             ///< two drives answer
  SlaveMask tolerated_;                              ///< also when two drives answer, by command
  std::array<std::uint8_t, kSlaves> evidence_ = {};  ///< of two drives
  SlaveMask census_;                                 ///< still to be asked
  SlaveMask unknown_;
  std::array<ParameterCheck, kSlaves> checks_ = {};
  std::array<IntervalNumber, kSlaves> suspect_again_ = {};  ///< when missing actual values count again
  std::uint8_t last_read_ = kSlaves - 1;
  IntervalNumber now_ = 0;
  bool active_ = false;
};

}  // namespace cansync
