#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "cansync/telegram/numbers.h"

namespace cansync {

/// The four bit rates of CANsync (M 3.1.1.1).
enum class BitRate : std::uint8_t { kbit125, kbit250, kbit500, mbit1 };

/// Times of one interval, each after the falling SYNC edge: the latest instant at which that telegram is
/// *started* (M 3.1.1.1; the manual says only "maximum", docs/cansync-protocol.md has the reasons for
/// "start").
struct SlotTimes {
  BitRate bit_rate;
  std::uint32_t bits_per_second;  ///< the same as a number, 125'000..1'000'000
  Duration interval;              ///< tSYNC, from one SYNC edge to the next
  Duration response;              ///< tRC: slave's answer to the previous interval's command
  Duration reference_one;         ///< tWRC1
  Duration actual_one;            ///< tRDC1
  Duration reference_two;         ///< tWRC2
  Duration actual_two;            ///< tRDC2
  Duration command;               ///< tCC
  Duration response_timeout;      ///< tRSPTO: end of a command to the start of its answer (M 3.2.0.1)
  std::uint16_t bus_length_m;     ///< longest bus, in metres

  /// Time of one bit.
  constexpr Duration bit_time() const noexcept { return Duration(1'000'000'000 / bits_per_second); }
};

/// The four permitted pairs of bit rate and interval, in the order of `BitRate`.
inline constexpr std::array<SlotTimes, 4> kSlotTimes = [] {
  using std::chrono::microseconds;
  const auto us = [](int t) { return Duration(microseconds(t)); };
  return std::array<SlotTimes, 4>{{
      {BitRate::kbit125, 125'000, us(8000), us(1920), us(3020), us(4310), us(5350), us(6640), us(7680),
       us(2100), 600},
      {BitRate::kbit250, 250'000, us(4000), us(900), us(1430), us(2100), us(2620), us(3290), us(3810),
       us(1100), 300},
      {BitRate::kbit500, 500'000, us(2000), us(460), us(730), us(1060), us(1320), us(1630), us(1890), us(600),
       134},
      {BitRate::mbit1, 1'000'000, us(1000), us(210), us(350), us(520), us(650), us(820), us(950), us(300),
       34},
  }};
}();

/// Slot times of a bit rate.
constexpr const SlotTimes& slot_times(BitRate rate) noexcept {
  return kSlotTimes[static_cast<unsigned>(rate)];
}

/// Slot times for a bit rate given in bit/s; nothing when it is not one of the four.
constexpr std::optional<SlotTimes> slot_times_for(std::uint32_t bits_per_second) noexcept {
  for (const SlotTimes& times : kSlotTimes) {
    if (times.bits_per_second == bits_per_second) return times;
  }
  return std::nullopt;
}

}  // namespace cansync
