#pragma once

#include "can/bus.h"
#include "daemon/loop/moment.h"

namespace cansyncd {

/// The edges of a timeline that another one of the same thread takes over: who leads writes it, who is led
/// reads it. Plain values; one thread.
struct LeadingEdges {
  IntervalNumber passed = 0;  ///< edges so far; the first has number 1
  can::Time newest{};         ///< of those
  can::Time next{};           ///< the next one
};

}  // namespace cansyncd
