#pragma once

#include <cstdint>
#include <optional>

#include "can/bus.h"
#include "daemon/loop/sync_line.h"
#include "daemon/loop/sync_snapshot.h"
#include "sync/input.h"
#include "sync/phase_lock.h"

namespace cansyncd {

/// The time base of a slave: edges that follow those of the SYNC input. Realtime thread only; realtime safe
/// after its construction.
class SyncFollower {
 public:
  /// Where the edges come from; each may be null. Both must outlive the follower.
  using Inputs = SyncSources;
  /// Edges that have passed.
  struct Passed {
    can::Time edge{};         ///< the newest
    std::uint64_t count = 0;  ///< 0: none
  };

  /// `every_interval`: the input has an edge in each interval, so that one that is missing can be told.
  SyncFollower(const sync_line::PhaseLockSettings& settings, bool every_interval,
               const Inputs& inputs) noexcept
      : interval_(settings.interval), every_interval_(every_interval), inputs_(inputs), lock_(settings) {}

  /// Once, before anything else.
  void begin(can::Bus& bus) noexcept;

  /// Takes the edges of the timeline up to `now`.
  Passed pass(can::Time now) noexcept;

  /// Looks at the input when that is due at `now`.
  void look(can::Time now) noexcept;
  /// Takes the edges that the input has seen.
  void take_edges() noexcept;

  /// Takes a frame when it is the software SYNC of the input; true: it is nothing for the slave.
  bool take_frame(const can::ReceivedFrame& received) noexcept;

  /// The newest edge of the input itself; nothing before the first.
  std::optional<can::Time> newest() const noexcept { return lock_.newest(); }
  /// The next edge of the timeline.
  can::Time next() const noexcept { return lock_.next(); }
  /// When `pass` or `look` must be called at the latest.
  can::Time next_deadline() const noexcept { return look_at_ < next() ? look_at_ : next(); }
  /// The timeline stands where the input's edges are, or goes on over some that are missing.
  bool tracking() const noexcept {
    return lock_.state() == sync_line::LockState::locked || lock_.state() == sync_line::LockState::holdover;
  }
  /// An edge is missing now.
  bool missing() const noexcept { return lock_.state() != sync_line::LockState::locked; }
  /// Intervals that were run through without their edge.
  std::uint64_t missing_edges() const noexcept { return missing_edges_; }
  /// Why the input's device cannot be read, as an error number; 0: it can.
  int input_error() const noexcept;
  SyncSnapshot snapshot() const noexcept;

 private:
  const can::Time interval_;
  const bool every_interval_;
  const Inputs inputs_;
  sync_line::PhaseLock lock_;
  can::Time look_at_{};
  std::uint64_t accepted_ = 0;  ///< edges of the input, as of the last look
  std::uint64_t missing_edges_ = 0;
};

}  // namespace cansyncd
