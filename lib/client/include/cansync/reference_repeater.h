#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "client.h"

namespace cansync::client {

/// More intervals in a row no daemon releases a value, unless its file says otherwise.
inline constexpr std::uint32_t kMostReleaseIntervals = 1000;

/// Intervals in a row, 1 and more, for which values that are given every `period` have to be released so that
/// two late ones leave no gap: three periods. `interval`: over 0 (MasterStatus.interval_length, ns).
constexpr std::uint32_t release_intervals_for(std::chrono::nanoseconds period,
                                              std::chrono::nanoseconds interval) noexcept {
  constexpr int kPeriods = 3;
  const auto intervals = (kPeriods * period.count() + interval.count() - 1) / interval.count();
  return intervals < 1 ? 1 : static_cast<std::uint32_t>(intervals < UINT32_MAX ? intervals : UINT32_MAX);
}

/// Gives the newest reference values again and again at a rate, from a thread of its own: for speeds and
/// torques whose program works slower than the line. Not for positions that must change in every interval:
/// those are written one for each interval (ReferenceWriter, `from_interval`).
///
/// A value goes on being repeated while its program hangs; stop, destruction and the end of the process end
/// it. After the daemon was started anew, or the mapping was changed, nothing is written until `take_up`.
/// Every function may be called from any thread.
class CANSYNC_PUBLIC ReferenceRepeater {
 public:
  /// `period`: 100 us and more, shorter counts as 100 us. `strength` as in ReferenceWriter;
  /// `release_intervals`: for how many intervals in a row each writing releases the values; 0: three periods
  /// (`release_intervals_for`, at most `kMostReleaseIntervals`). With less than a period there are intervals without values,
  /// and drives that need them fault. Waits at most 2 s for the daemon; throws NoDaemon, SetupError (also when
  /// three periods are more than that), std::system_error.
  ReferenceRepeater(Client& client, std::chrono::microseconds period, std::int32_t strength = 0,
                    std::uint32_t release_intervals = 0);
  /// Stops.
  ~ReferenceRepeater();
  ReferenceRepeater(const ReferenceRepeater&) = delete;
  ReferenceRepeater& operator=(const ReferenceRepeater&) = delete;

  /// The values that are repeated from now on: telegram 1 (values 0..3) or 2 (values 4..7); bit n of `valid`:
  /// value[n] counts, 0: the telegram is no longer written. Another telegram than 1 and 2 changes nothing.
  void set(std::uint8_t telegram, const std::array<std::int32_t, 4>& value, std::uint8_t valid);

  /// Ends the thread and gives both telegrams up: their release ends at once, and the next values of a weaker
  /// writer are taken. Nothing is written afterwards. Further calls do nothing.
  void stop();

  /// Other than `current`: the repeater has stopped by itself and forgotten its values, because the daemon
  /// was started anew or the mapping was changed; `error` says so.
  ReferenceStanding standing() const;

  /// Values that are set from now on are repeated again, for the daemon and the mapping in force now. Make
  /// settings and look at the line before.
  void take_up();
  /// Likewise, for what the program has looked at (Client::validity); is that over already, the standing says so.
  void take_up(const Validity& meant_for);

  /// Why the last write failed; empty when it did not.
  std::string error() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cansync::client
