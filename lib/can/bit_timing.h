#pragma once

#include <array>
#include <cstdint>
#include <optional>

/// Bit timing registers of the SJA1000 CAN controller, and what they mean in bit rate and sample point.
/// Pure functions; safe on the realtime thread.
namespace can {

/// Bus timing registers as the function blocks take them (M 4.9, b_BIT_TIMING0 and b_BIT_TIMING1).
/// BTR0: bits 7..6 SJW - 1, bits 5..0 BRP - 1. BTR1: bit 7 SAM, bits 6..4 TSEG2 - 1, bits 3..0 TSEG1 - 1.
struct BitTimingRegisters {
  std::uint8_t btr0 = 0;
  std::uint8_t btr1 = 0;
  friend constexpr bool operator==(const BitTimingRegisters&, const BitTimingRegisters&) = default;
};

/// Clock that makes the presets of the b maXX PLC the bit rates they are named for: 20 MHz (10 quanta a bit).
inline constexpr std::uint32_t kPlcClockHz = 20'000'000;
/// Clock that makes the presets of the Omega Drive-Line II right: 16 MHz (16 quanta a bit).
inline constexpr std::uint32_t kOmegaClockHz = 16'000'000;

/// What a pair of registers means at a given clock.
struct BitTiming {
  std::uint32_t bits_per_second = 0;  ///< rounded to the nearest
  bool exact = false;                 ///< the clock divides to this bit rate without a remainder
  std::uint8_t quanta = 0;            ///< time quanta of one bit, 3..25: 1 + TSEG1 + TSEG2
  std::uint32_t quantum_ps = 0;       ///< one time quantum, in picoseconds, rounded to the nearest
  std::uint16_t sample_point = 0;     ///< in 1/1000 of a bit, rounded to the nearest
  std::uint8_t prescaler = 0;         ///< BRP, 1..64
  std::uint8_t segment1 = 0;          ///< TSEG1 (propagation and phase 1) in quanta, 1..16
  std::uint8_t segment2 = 0;          ///< TSEG2 (phase 2) in quanta, 1..8
  std::uint8_t jump_width = 0;        ///< SJW in quanta, 1..4
  bool triple_sampling = false;       ///< SAM: three samples a bit
  friend constexpr bool operator==(const BitTiming&, const BitTiming&) = default;
};

/// Bit timing of `registers` with a controller clock of `clock_hz` (over 0; the controller halves it before
/// the prescaler). Nothing when the registers cannot work: clock 0, or a jump width over a segment.
std::optional<BitTiming> decode(BitTimingRegisters registers, std::uint32_t clock_hz) noexcept;

/// The two families of CANsync masters, which differ in clock and presets.
enum class Controller : std::uint8_t {
  plc,    ///< b maXX PLC with CANsync-Master (M 4.9)
  omega,  ///< Omega Drive-Line II (O 7.3.9); has no 1 Mbit/s
};

/// Clock in Hz of a controller family.
constexpr std::uint32_t clock_hz(Controller controller) noexcept {
  return controller == Controller::plc ? kPlcClockHz : kOmegaClockHz;
}

/// One row of the presets.
struct BitTimingPreset {
  Controller controller;
  std::uint8_t us_baudrate;  ///< value of the input us_BAUDRATE
  std::uint32_t bits_per_second;
  BitTimingRegisters registers;
};

/// All presets of the manuals (M 4.9, O 7.3.9).
inline constexpr std::array<BitTimingPreset, 7> kBitTimingPresets = {{
    {Controller::plc, 3, 125'000, {0x47, 0x34}},
    {Controller::plc, 4, 250'000, {0x43, 0x34}},
    {Controller::plc, 5, 500'000, {0x41, 0x34}},
    {Controller::plc, 6, 1'000'000, {0x40, 0x34}},
    {Controller::omega, 3, 125'000, {0x03, 0x1C}},
    {Controller::omega, 4, 250'000, {0x01, 0x1C}},
    {Controller::omega, 5, 500'000, {0x00, 0x1C}},
}};

/// Error bit 1 of w_ERR: input error with the bit timing or us_BAUDRATE (M 4.9).
inline constexpr std::uint16_t kBaudrateInputError = 0x0002;

/// What the inputs of the function block CANsync_INIT lead to.
struct BaudrateSelection {
  BitTimingRegisters registers;
  std::uint16_t error = 0;  ///< w_ERR: 0 or `kBaudrateInputError`
  friend constexpr bool operator==(const BaudrateSelection&, const BaudrateSelection&) = default;
};

/// Registers for the input `us_baudrate` (M 4.9): 0 takes `given` as it is; 3..6 (Omega: 3..5) a preset and
/// ignores `given`; anything else takes the preset of 125 kbit/s and reports the input error.
BaudrateSelection select_baudrate(Controller controller, std::uint8_t us_baudrate,
                                  BitTimingRegisters given) noexcept;

}  // namespace can
