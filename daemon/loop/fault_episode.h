#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <optional>

#include "can/bus.h"

namespace cansyncd {

/// Lets things happen a number of times in an hour. Realtime safe; one thread.
template <std::size_t most>
class HourlyBound {
 public:
  static constexpr can::Time kSpan = std::chrono::hours(1);

  bool allows(can::Time now) const noexcept {
    const std::optional<can::Time>& oldest = last_.at(next_ % most);
    return !oldest || now - *oldest >= kSpan;
  }
  void count(can::Time now) noexcept { last_.at(next_++ % most) = now; }

 private:
  std::array<std::optional<can::Time>, most> last_;
  std::size_t next_ = 0;
};

/// Of faults of one kind those that get a recording of their own: the first, and the next after a quiet time; never
/// more than `kMost` in an hour. So a fault that repeats neither hides its beginning nor wears the disk out. Realtime
/// safe; one thread.
class FaultEpisode {
 public:
  static constexpr can::Time kQuiet = std::chrono::minutes(1);  ///< without such a fault
  static constexpr std::size_t kMost = 2;

  /// A fault at `now`, by a clock that never goes back. True: it is to be recorded; `recorded` follows when it gets a
  /// recording of its own.
  bool begins(can::Time now) noexcept {
    const bool quiet = !last_ || now - *last_ >= kQuiet;
    last_ = now;
    return quiet && bound_.allows(now);
  }
  /// The fault that `begins` wanted has a recording of its own.
  void recorded(can::Time now) noexcept { bound_.count(now); }
  /// No recording shows it: the next fault begins again.
  void missed() noexcept { last_.reset(); }

 private:
  std::optional<can::Time> last_;
  HourlyBound<kMost> bound_;
};

}  // namespace cansyncd
