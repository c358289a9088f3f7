#pragma once

#include <cstdint>

#include "can/bus.h"

namespace cansyncd {

/// Counts the intervals of a bus, or the wake-ups of a protocol without intervals; never repeats.
using IntervalNumber = std::uint64_t;

/// An instant on all three timelines.
struct Moment {
  IntervalNumber interval = 0;
  can::Time bus{};          ///< clock of the bus
  can::Time wall_clock{0};  ///< CLOCK_REALTIME, ns since 1970
};

}  // namespace cansyncd
