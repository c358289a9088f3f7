#pragma once

#include <chrono>
#include <cstdint>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// What a slave does about a fault of the communication, the stronger the later; it is the application that
/// does it (O 7.2).
enum class SlaveReaction : std::uint8_t {
  report,         ///< nothing but the fault itself
  quick_stop,     ///< stop as fast as the drive can
  pulse_inhibit,  ///< no torque at once
};

/// Faults of the communication that a slave finds by itself.
enum class SlaveFault : std::uint8_t {
  none,
  sync_lost,           ///< edges stayed away for too long
  references_missing,  ///< too many intervals in a row without a reference value
};

/// What is supervised, and what follows.
struct SlaveSupervisionSettings {
  Duration interval = std::chrono::milliseconds(1);  ///< from edge to edge
  /// From "activate", with edges coming, until synchronized.
  Duration lock_time = std::chrono::milliseconds(500);
  std::uint32_t edges_until_fault = 10;   ///< edges missing in a row, at least 2
  std::uint32_t misses_until_fault = 10;  ///< intervals in a row without a reference value; 0 = never
  SlaveReaction on_sync_lost = SlaveReaction::quick_stop;
  SlaveReaction on_references_missing = SlaveReaction::quick_stop;
};

/// Supervises what a slave gets from its master: SYNC edges and reference values (O 7.2). Synchronized after
/// edges have come for the lock time; lost, with a fault, when too many stay away in a row, while a single
/// one is ridden through. Reference values count once the first has come.
///
/// At each edge: `edge`, then `references`; `check` in between whenever somebody wants to know. Times are on
/// any one clock. Nothing allocates, blocks or throws; not thread safe.
class SlaveSupervision {
 public:
  /// Takes what to supervise; before the first edge nothing is missing.
  explicit SlaveSupervision(const SlaveSupervisionSettings& settings) noexcept;

  /// An edge at `now`; the lock time runs while `activated`. Returns the intervals that have passed since the
  /// edge before: 1 normally, more when edges were missing, 0 for the first edge and for one that came out of
  /// turn.
  std::uint32_t edge(Duration now, bool activated) noexcept;

  /// So many edges before the next one did not stay away: nobody was told of each.
  void run_through(std::uint64_t edges) noexcept {
    if (seen_) last_ += interval_ * static_cast<std::int64_t>(edges);
  }

  /// Notices at `now` that edges stay away.
  void check(Duration now) noexcept {
    if (synchronized_ && now - last_ > silence_) lose();
  }

  /// `intervals` have passed, as `edge` returned them; `fresh`: the last of them brought the reference values
  /// that are supervised. Returns the intervals without, at most `kMostMissing`: over so many the application
  /// has to extrapolate.
  std::uint32_t references(std::uint32_t intervals, bool fresh) noexcept;
  static constexpr std::uint32_t kMostMissing = 64;

  /// Until the next reference value there is none, and none is missing.
  void forget_references() noexcept;

  /// True from the end of the lock time until edges are lost: bit 15 of the status word.
  bool synchronized() const noexcept { return synchronized_; }
  /// The application's status word with bit 15 as it is (M 3.2.0.1).
  std::uint16_t status_word(std::uint16_t application) const noexcept {
    constexpr std::uint16_t kSynchronized = 0x8000;
    return static_cast<std::uint16_t>(synchronized_ ? application | kSynchronized
                                                    : application & ~kSynchronized);
  }

  /// The last interval had no reference value: the last one is carried on.
  bool extrapolating() const noexcept { return extrapolating_; }
  /// Intervals in a row without a reference value.
  std::uint32_t misses() const noexcept { return misses_; }

  /// The graver of the faults that stand until they are acknowledged: `sync_lost` before
  /// `references_missing`.
  SlaveFault fault() const noexcept { return standing_.graver(); }
  bool stands(SlaveFault fault) const noexcept { return standing_.has(fault); }  ///< That one does.
  /// The strongest that the settings have for the faults that stand; `report` without one.
  SlaveReaction reaction() const noexcept;
  /// What the settings have for that fault.
  SlaveReaction reaction_to(SlaveFault fault) const noexcept;
  /// A fault that was found, once, the graver first; `none` when there is no news.
  SlaveFault take_fault() noexcept;
  /// That fault is over; what is still wrong brings it again.
  void acknowledge(SlaveFault fault) noexcept { standing_.remove(fault); }
  /// All are.
  void acknowledge() noexcept { standing_ = {}; }

  /// Time of the last edge.
  Duration last_edge() const noexcept { return last_; }
  /// Edges that stayed away between others since the construction.
  std::uint32_t missed_edges() const noexcept { return missed_edges_; }
  /// Intervals without a reference value that was due, since the start.
  std::uint32_t missed_references() const noexcept { return missed_references_; }

  /// As at the start; keeps the count of missed edges.
  void reset() noexcept;

 private:
  struct Faults {
    bool sync_lost = false;
    bool references_missing = false;
    bool has(SlaveFault fault) const noexcept {
      return (fault == SlaveFault::sync_lost && sync_lost) ||
             (fault == SlaveFault::references_missing && references_missing);
    }
    SlaveFault graver() const noexcept {
      if (sync_lost) return SlaveFault::sync_lost;
      return references_missing ? SlaveFault::references_missing : SlaveFault::none;
    }
    void add(SlaveFault fault) noexcept { set(fault, true); }
    void remove(SlaveFault fault) noexcept { set(fault, false); }
    void set(SlaveFault fault, bool on) noexcept {
      if (fault == SlaveFault::sync_lost) sync_lost = on;
      if (fault == SlaveFault::references_missing) references_missing = on;
    }
  };

  void lose() noexcept;
  void raise(SlaveFault fault) noexcept;

  Duration last_{};
  Duration locking_since_{};
  Duration interval_;
  Duration on_time_;  ///< elapsed time below which no edge is missing
  Duration silence_;
  Duration lock_time_;
  std::uint32_t missed_edges_ = 0;
  std::uint32_t misses_ = 0;
  std::uint32_t missed_references_ = 0;
  std::uint32_t misses_until_fault_;
  SlaveReaction on_sync_lost_;
  SlaveReaction on_references_missing_;
  Faults standing_;
  Faults news_;
  bool seen_ = false;
  bool locking_ = false;
  bool synchronized_ = false;
  bool reference_seen_ = false;
  bool extrapolating_ = false;
};

}  // namespace cansync
