#pragma once

#include <cstdint>

#include "can/bus.h"
#include "can/frame.h"
#include "can/frame_length.h"

namespace cansyncd {

/// Share of the time in which the bus carried frames. One thread; realtime safe.
class BusLoad {
 public:
  /// `bits_per_second` over 0.
  explicit BusLoad(std::uint32_t bits_per_second) noexcept : bits_per_second_(bits_per_second) {}

  /// A frame stood on the bus, whoever sent it.
  void add(const can::Frame& frame) noexcept { add(can::frame_bits(frame)); }
  /// Likewise; `bits`: of the frame, as `can::frame_bits` counts them.
  void add(unsigned bits) noexcept { bits_ += bits; }

  /// Load since the previous call in permille of the time up to `now`; the first call only begins.
  std::uint32_t take(can::Time now) noexcept {
    const std::int64_t elapsed_us = (now - since_).count() / 1000;
    const std::uint64_t bits = bits_;
    since_ = now;
    bits_ = 0;
    if (!begun_ || elapsed_us <= 0) {
      begun_ = true;
      return 0;
    }
    const std::uint64_t possible = bits_per_second_ * static_cast<std::uint64_t>(elapsed_us) / 1'000'000;
    return possible == 0 ? 0 : static_cast<std::uint32_t>(bits * 1000 / possible);
  }

 private:
  std::uint64_t bits_per_second_;
  std::uint64_t bits_ = 0;
  can::Time since_{};
  bool begun_ = false;
};

}  // namespace cansyncd
