#pragma once

#include <cstdint>

#include "can/bus.h"
#include "cansync/telegram/numbers.h"

namespace sim {

/// A drive's lock on the SYNC line: synchronized after edges have come for the lock time, lost when too many
/// stay away in a row. A single missing edge is ridden through (O 7.2). Nothing allocates, blocks or throws.
class DriveSync {
 public:
  /// `interval` is the time from edge to edge; `missing_until_lost` edges in a row (at least 2) lose the
  /// lock.
  DriveSync(cansync::Duration interval, cansync::Duration lock_time,
            std::uint32_t missing_until_lost) noexcept;

  /// An edge at `now`; the lock time runs while `activated`. Returns the intervals that have passed since the
  /// edge before: 1 normally, more when edges were missing, 0 for the first edge and for one that came out of
  /// turn.
  std::uint32_t edge(can::Time now, bool activated) noexcept;

  /// Notices at `now` that edges stay away.
  void check(can::Time now) noexcept {
    if (synchronized_ && now - last_ > silence_) lose();
  }

  bool synchronized() const noexcept { return synchronized_; }

  /// True once after the lock was lost.
  bool take_loss() noexcept {
    const bool result = loss_;
    loss_ = false;
    return result;
  }

  /// Time of the last edge.
  can::Time last_edge() const noexcept { return last_; }

  /// Edges that stayed away between others since the construction.
  std::uint32_t missed() const noexcept { return missed_; }

  /// As after power-on; keeps the count of missed edges.
  void reset() noexcept;

 private:
  void lose() noexcept;

  can::Time last_{};
  can::Time locking_since_{};
  cansync::Duration interval_;
  cansync::Duration on_time_;  ///< elapsed time below which no edge is missing
  cansync::Duration silence_;
  cansync::Duration lock_time_;
  std::uint32_t missed_ = 0;
  bool seen_ = false;
  bool locking_ = false;
  bool synchronized_ = false;
  bool loss_ = false;
};

}  // namespace sim
