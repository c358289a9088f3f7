#pragma once

#include <cstdint>
#include <string>

#include "daemon/cansync/exchange.h"
#include "ledger.h"
#include "plan.h"

namespace cansyncd::campaign {

/// Watches that the line is back in normal operation in time after the last fault. Normal operation: the
/// master is active, every slave responds and is synchronized, and a job for every slave ends as done.
class Recovery {
 public:
  explicit Recovery(const Plan& plan) : plan_(plan) {}

  enum class Phase : std::uint8_t {
    faults,      ///< something is still provoked
    recovering,  ///< nothing is; not everything runs
    probing,     ///< everything seems to run; a job for every slave is under way
    normal,      ///< all of these have ended as done
  };

  /// Intervals from the last fault to normal operation with what is open in the ledger now. What goes in:
  /// the operator's reset of the controller and the mode (kOperator); the jobs that are open, each telegram
  /// of which waits for its slave's turn; two status words of every slave a status period apart, the
  /// activation, which a slave may have missed, and the lock time in between; and the probes.
  std::uint64_t bound(const Ledger& ledger) const noexcept;

  /// The last fault was in an interval before `tick`.
  void faults_are_over(std::uint64_t tick, const Ledger& ledger) noexcept {
    phase_ = Phase::recovering;
    begun_ = tick;
    deadline_ = tick + bound(ledger);
  }

  /// Looks at the state of things in interval `tick`.
  void look(std::uint64_t tick, const MasterSnapshot& now, const Ledger& ledger) noexcept;

  /// The probe jobs were pushed.
  void probing() noexcept { phase_ = Phase::probing; }
  /// All of them have ended; `done`: well.
  void probed(bool done, std::uint64_t tick) noexcept {
    failed_ = failed_ || !done;
    phase_ = Phase::normal;
    took_ = tick - begun_;
  }

  Phase phase() const noexcept { return phase_; }
  /// Every slave is there, no old job is open: the probes may be sent.
  bool ready() const noexcept { return ready_; }
  bool overdue() const noexcept { return overdue_; }
  bool failed() const noexcept { return failed_; }
  std::uint64_t allowed() const noexcept { return deadline_ - begun_; }
  std::uint64_t took() const noexcept { return took_; }
  /// What is missing, in words.
  const std::string& missing() const noexcept { return missing_; }

 private:
  const Plan& plan_;
  Phase phase_ = Phase::faults;
  std::uint64_t begun_ = 0;
  std::uint64_t deadline_ = 0;
  std::uint64_t took_ = 0;
  bool ready_ = false;
  bool overdue_ = false;
  bool failed_ = false;
  std::string missing_;
};

}  // namespace cansyncd::campaign
