#pragma once

#include "can/bus.h"

namespace can {

/// How far the wall clock is ahead of a steady clock, and how wrong that may be.
struct ClockOffset {
  Time ahead{};              ///< wall clock - steady clock
  Time doubt = Time::max();  ///< half of what the reading took
  Time now{};                ///< steady clock, read last
};

/// Reads the wall clock between two readings of the steady one, up to three times, and keeps the reading that
/// took least; one with at most `will_do` of doubt ends it. A thread that is held up in between knows the
/// offset no better. Realtime safe, as far as the two are, which take nothing and return a Time.
template <class Steady, class Wall>
ClockOffset read_clock_offset(Steady steady, Wall wall, Time will_do) noexcept {
  constexpr unsigned kTries = 3;
  ClockOffset best;
  for (unsigned i = 0; i < kTries && best.doubt > will_do; ++i) {
    const Time before = steady();
    const Time read = wall();
    const Time now = steady();
    const Time half = (now - before) / 2;
    if (half < best.doubt) {
      best.ahead = read - (before + half);
      best.doubt = half;
    }
    best.now = now;
  }
  return best;
}

}  // namespace can
