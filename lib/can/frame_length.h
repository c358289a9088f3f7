#pragma once

#include <chrono>
#include <cstdint>
#include <ratio>

#include "can/frame.h"

/// How long a frame stands on the bus, to the bit (CAN 2.0, parts A and B). Pure functions; none allocates or
/// throws; safe on the realtime thread.
///
/// All lengths count from the start-of-frame bit to the end of the interframe space of 3 bits, so that two
/// frames in a row need the sum of their lengths. A data length over 8 counts as 8. A remote frame has its
/// data length code but no data bits. An error frame is taken as `kErrorFrameBits`.
namespace can {

/// Bits of the interframe space, the last ones of every length given here.
inline constexpr unsigned kInterframeBits = 3;
/// Bits after the CRC sequence, never stuffed: CRC delimiter, acknowledge slot and delimiter, end of frame,
/// interframe space.
inline constexpr unsigned kTailBits = 1 + 2 + 7 + kInterframeBits;
/// An error frame with the interframe space after it: 6 flag bits, 1 bit by which the other nodes' flags lag,
/// 8 delimiter bits, 3 bits of interframe space.
inline constexpr unsigned kErrorFrameBits = 6 + 1 + 8 + kInterframeBits;

/// The 15-bit CRC sequence of `frame` (polynomial 0x4599), computed over start of frame to the end of data.
/// 0 for an error frame.
std::uint16_t crc15(const Frame& frame) noexcept;

/// Stuff bits of `frame`, counted from the start of frame to the end of the CRC sequence. 0 for an error
/// frame.
unsigned stuff_bits(const Frame& frame) noexcept;

/// Length of `frame` on the bus in bits, with the CRC and the stuff bits of this very frame.
unsigned frame_bits(const Frame& frame) noexcept;

/// Length in bits without stuff bits of a standard data frame with `dlc` bytes (0..8): 47 + 8 * dlc.
constexpr unsigned unstuffed_bits(std::uint8_t dlc) noexcept {
  return 34u + 8u * (dlc > 8 ? 8u : dlc) + kTailBits;
}

/// Length in bits of a standard data frame with `dlc` bytes (0..8) when a stuff bit follows every four bits:
/// the bound that timing plans use. Fixed bits of the header keep real frames a little shorter.
constexpr unsigned worst_case_bits(std::uint8_t dlc) noexcept {
  const unsigned stuffed = 34u + 8u * (dlc > 8 ? 8u : dlc);
  return stuffed + (stuffed - 1) / 4 + kTailBits;
}

/// Bits by which a frame with a 29-bit identifier is longer, without stuff bits, than one with an 11-bit identifier.
inline constexpr unsigned kExtendedBits = 20;
/// The longest frame, with all the stuff bits that it can have.
inline constexpr unsigned kLongestFrameBits = 160;

/// Length in bits without stuff bits of a data or remote frame: shorter than that it never is.
constexpr unsigned least_bits(const Frame& frame) noexcept {
  return unstuffed_bits(frame.remote ? 0 : frame.dlc) + (frame.extended ? kExtendedBits : 0);
}

/// All the time of a bus, in the unit of `share_of_bus`.
inline constexpr std::int64_t kWholeBus = 1'000'000;

/// What `bits`, 0..1,000,000, take of the bus when they come again each `period`, over 0: millionths of its time, rounded
/// down; over `kWholeBus` the bus cannot carry it. `bits_per_second`: over 0.
constexpr std::int64_t share_of_bus(std::int64_t bits, std::chrono::nanoseconds period,
                                    std::int64_t bits_per_second) noexcept {
  return bits * std::nano::den / bits_per_second * kWholeBus / period.count();
}

}  // namespace can
