#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "cansync/channel/jobs.h"
#include "cansync/master.h"
#include "cansync/process_data/release_status.h"
#include "cansync/settings/settings.h"
#include "cansync/telegram/numbers.h"

namespace cansync {

/// How long the reference values of one telegram are released: as often as each update says, no longer than
/// they are young enough, and a little longer when they are to be held. Intervals that were skipped count as
/// used and as held. A release that has ended is never taken up again without new values, and none begins
/// with values that have grown too old, wherever they waited. Counts interval numbers alone. Realtime safe;
/// not thread safe.
class ReferenceRelease {
 public:
  /// `listener` must outlive this object.
  ReferenceRelease(Channel channel, const ProcessSettings& settings, MasterListener& listener) noexcept
      : channel_(channel),
        too_old_after_(settings.too_old_after),
        hold_too_old_(settings.hold_too_old),
        listener_(listener) {}

  /// Active operation ends: forgets what was given.
  void stop() noexcept;

  /// Keeps an update until its interval; false: no room.
  bool add(const ReferenceUpdate& update) noexcept;

  /// Forgets what waits, and stops the release: at once, or after `hold` more intervals when it runs. A hold
  /// that runs already is not made longer.
  void withdraw(std::uint32_t hold) noexcept;

  /// The values that were given mean something else from now on: forgets what waits, and stops the release.
  void mapping_changed() noexcept;

  /// The bus is gone: forgets what waits, and stops the release.
  void bus_lost() noexcept;

  /// Once an interval, before the telegram is built: the next update that is due, for `take` or `refuse`.
  std::optional<ReferenceUpdate> next_due(IntervalNumber now) noexcept;
  /// An update of `next_due` is taken into use.
  void take(const ReferenceUpdate& due, IntervalNumber now) noexcept;
  /// An update of `next_due` is beyond a limit: what is released goes on as if it had not come.
  void refuse() noexcept { ++status_.beyond_limits; }
  /// Once an interval, after all that is due: is the telegram sent in this interval?
  bool decide(IntervalNumber now) noexcept;
  /// The telegram was handed to the bus: its values are used once, and their release has begun.
  void sent() noexcept;
  /// The telegram was left out: its values are used once too, and may still grow too old to begin.
  void left_out() noexcept;

  /// As of the last `decide`, or of what ended the release since.
  const ReleaseStatus& status() const noexcept { return status_; }

 private:
  using State = ReleaseStatus::State;
  using Cause = ReleaseStatus::Cause;
  static constexpr std::size_t kPendingUpdates = 16;
  static constexpr IntervalNumber kQuietIntervals = 1000;

  /// False: nothing was released or held.
  bool forget(Cause cause) noexcept;
  void end(Cause cause) noexcept;
  void skip_missed(IntervalNumber now) noexcept;
  void never_begin(IntervalNumber now) noexcept;
  void tell_came_too_old(IntervalNumber now) noexcept;
  void grow_old() noexcept;
  void hold(IntervalNumber until, Cause cause) noexcept;
  void tell(MasterEvent::Code code, std::uint32_t expected = 0) noexcept;
  void tell_release(IntervalNumber now) noexcept;

  Channel channel_;
  std::uint32_t too_old_after_;
  std::uint32_t hold_too_old_;
  MasterListener& listener_;
  std::array<ReferenceUpdate, kPendingUpdates> pending_ = {};
  std::size_t pending_count_ = 0;
  ReleaseStatus status_;
  IntervalNumber last_ = 0;                 ///< interval looked at last
  Cause end_cause_ = Cause::used_up;        ///< why `remaining_` came to 0
  std::uint32_t remaining_ = 0;             ///< intervals for which the values are still released
  bool watched_ = false;                    ///< the values' age is looked at
  IntervalNumber begins_before_ = 0;        ///< of values that were not on the bus yet; 0: no limit
  std::uint32_t hold_wanted_ = 0;           ///< intervals to hold, from the next telegram on
  IntervalNumber hold_until_ = 0;           ///< first interval no longer held
  bool told_released_ = false;              ///< as last told to the listener
  IntervalNumber quiet_until_ = 0;          ///< no further "stopped" is told before
  IntervalNumber too_old_quiet_until_ = 0;  ///< no further values that came too old are told before
};

}  // namespace cansync
