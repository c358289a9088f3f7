#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "can/frame.h"
#include "cansync/settings/timing.h"

namespace cansync::observe {

/// Tells the interval, and with it the bit rate, by how far telegrams of one kind stand apart: of each kind
/// there is at most one in an interval. SYNC edges count before WRC1, WRC1 before WRC2, WRC2 before commands.
class IntervalVote {
 public:
  /// A SYNC edge.
  void sync(Duration at) noexcept;
  /// Any frame; those that stand once in an interval count.
  void frame(Duration at, const can::Frame& frame) noexcept;

  /// What comes next has no relation in time to what came before.
  void begin_anew() noexcept;

  /// What was told so far.
  struct Result {
    BitRate bit_rate = BitRate::mbit1;
    std::uint64_t votes = 0;      ///< 0: nothing speaks for any
    std::uint64_t against = 0;    ///< of the same kind, for the others
    std::uint64_t among = 0;      ///< distances of the same kind, those that fit no interval included
    std::uint64_t in_step = 0;    ///< of those, a whole number of intervals
    std::uint64_t too_short = 0;  ///< of those, under half of the interval
    bool by_sync = false;
    Duration mean{};  ///< of those that voted for it
    /// Hardly any distance is too short for this interval.
    bool steady() const noexcept { return votes > 0 && 8 * too_short <= among; }
  };
  /// The interval that most of the best kind speak for.
  Result result() const noexcept;

 private:
  static constexpr unsigned kKinds = 4;
  struct Kind {
    std::optional<Duration> last;
    std::uint64_t among = 0;
    std::array<std::uint64_t, kSlotTimes.size()> votes = {};
    std::array<std::uint64_t, kSlotTimes.size()> in_step = {};
    std::array<std::uint64_t, kSlotTimes.size()> too_short = {};
    std::array<Duration, kSlotTimes.size()> sum = {};
  };
  void vote(unsigned kind, Duration at) noexcept;

  std::array<Kind, kKinds> kinds_ = {};
};

}  // namespace cansync::observe
