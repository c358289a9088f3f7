#pragma once

#include <array>
#include <cstdint>

#include "cansync/telegram/mapping.h"
#include "cansync/telegram/numbers.h"

namespace cansync_slave {

/// What the telegrams of both channels of one sender have brought so far. Plain values.
struct ReceivedValues {
  cansync::Values values = {};
  std::uint8_t arrived = 0;  ///< bit 0/1: telegram 1/2 came just now
  std::uint8_t ever = 0;     ///< bit 0/1: likewise, at least once
  std::uint8_t words = 0;    ///< `cansync::word_mask` of the mapping
  /// Number of the interval in which each came last.
  std::array<cansync::IntervalNumber, cansync::kChannels> interval = {};
  std::int64_t receive_time = 0;  ///< CLOCK_REALTIME (ns) of the newest telegram's last bit

  /// A telegram came.
  void took(cansync::Channel channel, const cansync::Values& all, cansync::IntervalNumber in,
            std::int64_t time) noexcept {
    const unsigned place = index(channel);
    values = all;
    arrived = static_cast<std::uint8_t>(1u << place);
    ever = static_cast<std::uint8_t>(ever | arrived);
    interval[place] = in;
    receive_time = time;
  }
};

}  // namespace cansync_slave
