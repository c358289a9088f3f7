#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

namespace sync_line {

/// Instants and durations in nanoseconds; which clock is said where it is used.
using Time = std::chrono::nanoseconds;

/// How well a timeline follows its input.
enum class LockState : std::uint8_t {
  searching,  ///< edges arrive, the timeline moves towards them; also before the first edge
  locked,     ///< the timeline's edges stand where the input's are
  holdover,   ///< edges are missing; the timeline goes on with the period learned
  lost,       ///< edges are missing for longer than the hold-over time; the timeline still goes on
};

/// What a phase lock is told.
struct PhaseLockSettings {
  Time interval = std::chrono::milliseconds(1);  ///< nominal distance of the timeline's edges
  std::uint32_t spacing = 1;                     ///< intervals between two edges of the input, at least 1
  /// Most by which one interval may be longer or shorter than nominal; also twice the greatest deviation of
  /// the input's frequency that can be followed.
  Time greatest_step = std::chrono::microseconds(1);
  Time holdover = std::chrono::seconds(1);  ///< from the beginning of holdover until lost
};

/// Numbers of a phase lock since its beginning.
struct PhaseLockCounters {
  std::uint64_t accepted = 0;  ///< edges that were used
  std::uint64_t rejected = 0;  ///< edges too near to another one, too far from the timeline, or out of order
};

/// A timeline of edges that follows the edges of an input: a proportional-integral phase lock.
///
/// Each input edge is compared with the nearest edge of the timeline. While searching, a phase far off is
/// approached at `greatest_step` per interval, always in one direction; near by, phase and frequency are
/// filtered, and edges far off are not used as long as most are near. Locked, an edge more than a tenth of an
/// interval off is not used; 16 of them in a row that agree (3 when `spacing` > 1) mean that the input has
/// jumped, and the search begins again. Without edges the timeline goes on with the learned period. Whatever
/// the input does, no interval deviates from the nominal one by more than `greatest_step`.
///
/// Pure: no clock, no system call, no allocation; nothing throws. One thread; realtime safe.
class PhaseLock {
 public:
  explicit PhaseLock(const PhaseLockSettings& settings) noexcept;

  /// Sets the timeline's next edge and forgets everything learned.
  void begin(Time next) noexcept;

  /// The timeline's next edge, on the clock of the input's edges.
  Time next() const noexcept { return next_; }

  /// Length of an interval without phase correction, in ns.
  double period() const noexcept;

  /// `n` edges of the timeline have passed.
  void advance(std::uint64_t n = 1) noexcept;

  /// An edge of the input stood at `at`.
  void input(Time at) noexcept;

  LockState state() const noexcept { return state_; }

  /// Since when edges have been missing; 0 unless holdover or lost.
  Time holdover() const noexcept;

  /// The input's newest edge, also one that is not followed; nothing before the first.
  std::optional<Time> newest() const noexcept {
    return any_seen_ ? std::optional<Time>(last_seen_) : std::nullopt;
  }

  /// How far the input's edges stand after the timeline's, filtered.
  Time phase_error() const noexcept { return Time(static_cast<Time::rep>(mean_error_)); }

  const PhaseLockCounters& counters() const noexcept { return counters_; }

 private:
  struct Gains {
    double proportional;
    double integral;
  };

  bool tracking() const noexcept { return state_ == LockState::locked || state_ == LockState::holdover; }
  double error_of(Time at) const noexcept;
  void track(Time at, double error) noexcept;
  void search(Time at, double error) noexcept;
  void slew(double error) noexcept;
  void learn_period(Time at) noexcept;
  void filter(double error, const Gains& gains) noexcept;
  void accept(Time at) noexcept;
  void set_outlier(double error) noexcept;

  const PhaseLockSettings settings_;
  const double interval_;
  const double step_;

  Time next_{0};
  double fraction_ = 0;   ///< of a nanosecond, what `next_` leaves out
  double frequency_ = 0;  ///< ns by which the input's interval is longer than nominal
  double share_ = 0;      ///< phase correction of each of the coming `share_left_` intervals
  std::uint64_t share_left_ = 0;

  LockState state_ = LockState::searching;
  std::uint64_t since_accepted_ = 0;  ///< intervals
  bool any_accepted_ = false;
  Time last_accepted_{0};
  Time last_seen_{0};
  bool any_seen_ = false;
  bool slewing_ = false;
  double slew_target_ = 0;  ///< what is left to move, with its direction
  double mean_error_ = 0;
  std::uint32_t good_ = 0;      ///< edges in a row near enough to be locked
  std::uint32_t outliers_ = 0;  ///< edges in a row that agree with each other but not with the timeline
  double outlier_error_ = 0;
  PhaseLockCounters counters_;
};

/// The state in one word: "searching", "locked", "holdover", "lost".
const char* name(LockState state) noexcept;

}  // namespace sync_line
