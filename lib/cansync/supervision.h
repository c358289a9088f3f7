#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "cansync/master.h"
#include "cansync/numbers.h"
#include "cansync/settings.h"
#include "cansync/telegram.h"

namespace cansync {

/// Knows which slaves respond and are synchronized: sends "SYNC mode: activate", reads status words, counts
/// silence (M 3.2.0.1, 3.2.2.3, 3.2.2.7). Realtime safe; not thread safe.
class Supervision {
 public:
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
  bool urgent() const noexcept { return !to_activate_.empty() || !first_round_.empty(); }

  /// True while status words should not wait for ever behind jobs: in set-up until all are synchronized, in
  /// active operation when a slave sent no actual values.
  bool pressing() const noexcept { return active_ ? !suspect_.empty() : synchronized_ != configured_; }

  /// What supervision wants to send in this interval; nothing when no status word is due.
  std::optional<Telegram> telegram() noexcept;
  /// The telegram was handed to the bus.
  void sent(const Telegram& telegram) noexcept;

  /// Answer to a status read. Step::ignored when it is not.
  bool answered(SlaveNumber slave, const ParameterReply& reply) noexcept;

  /// Any telegram of a slave arrived.
  void seen(SlaveNumber slave) noexcept;
  /// A command to this slave got its answer; `response` from the end of the command to the end of the answer.
  void responded(SlaveNumber slave, std::optional<Duration> response, bool slow) noexcept;
  /// A command to this slave got no answer.
  void silent(SlaveNumber slave) noexcept;
  /// A slave that was asked for actual values sent none.
  void missed_actual(SlaveNumber slave) noexcept;

  /// Nothing can be sent or received: nothing is known of any slave, and each that answers again is
  /// activated. No event for each slave; whoever tells that the bus is gone has said it all.
  void bus_lost() noexcept;

  /// The mask of configured slaves that do not yet meet the enable rule.
  SlaveMask missing(EnableRule rule) const noexcept;

  const SlaveStatus& status(SlaveNumber slave) const noexcept { return status_[slave.value()]; }

 private:
  SlaveStatus& at(SlaveNumber slave) noexcept { return status_[slave.value()]; }
  std::optional<SlaveNumber> next_due() noexcept;
  bool due(SlaveNumber slave) const noexcept;
  void set_synchronized(SlaveNumber slave, bool synchronized) noexcept;
  void tell(MasterEvent::Code code, std::optional<SlaveNumber> slave) noexcept;

  const MasterSettings& settings_;
  MasterListener& listener_;
  SlaveMask configured_;
  IntervalNumber period_;
  std::array<SlaveStatus, kSlaves> status_ = {};
  std::array<IntervalNumber, kSlaves> next_read_ = {};
  std::array<std::uint8_t, kSlaves> silence_ = {};
  SlaveMask to_activate_;
  SlaveMask first_round_;
  SlaveMask responding_;
  SlaveMask synchronized_;
  SlaveMask suspect_;  ///< sent no actual values when asked, and nothing since
  SlaveMask cut_off_;  ///< responded until the bus was lost
  std::uint8_t last_read_ = kSlaves - 1;
  IntervalNumber now_ = 0;
  bool active_ = false;
};

}  // namespace cansync
