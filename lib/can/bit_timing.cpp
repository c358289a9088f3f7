#include "can/bit_timing.h"

#include <algorithm>

namespace can {
namespace {

constexpr std::uint64_t divide_rounded(std::uint64_t value, std::uint64_t by) {
  return (value + by / 2) / by;
}

}  // namespace

std::optional<BitTiming> decode(BitTimingRegisters registers, std::uint32_t clock_hz) noexcept {
  BitTiming timing;
  timing.jump_width = static_cast<std::uint8_t>((registers.btr0 >> 6) + 1);
  timing.prescaler = static_cast<std::uint8_t>((registers.btr0 & 0x3F) + 1);
  timing.triple_sampling = (registers.btr1 & 0x80) != 0;
  timing.segment2 = static_cast<std::uint8_t>(((registers.btr1 >> 4) & 0x07) + 1);
  timing.segment1 = static_cast<std::uint8_t>((registers.btr1 & 0x0F) + 1);
  // A resynchronisation by more than a segment would move the edge past the sample point.
  if (clock_hz == 0 || timing.jump_width > std::min(timing.segment1, timing.segment2)) return std::nullopt;

  const unsigned quanta = 1u + timing.segment1 + timing.segment2;
  const std::uint64_t clocks_per_quantum = std::uint64_t{2} * timing.prescaler;
  const std::uint64_t clocks_per_bit = clocks_per_quantum * quanta;
  timing.quanta = static_cast<std::uint8_t>(quanta);
  timing.bits_per_second = static_cast<std::uint32_t>(divide_rounded(clock_hz, clocks_per_bit));
  timing.exact = clock_hz % clocks_per_bit == 0;
  const std::uint64_t quantum_ps = divide_rounded(clocks_per_quantum * 1'000'000'000'000, clock_hz);
  timing.quantum_ps = static_cast<std::uint32_t>(std::min<std::uint64_t>(quantum_ps, UINT32_MAX));
  timing.sample_point =
      static_cast<std::uint16_t>(divide_rounded(std::uint64_t{1000} * (1u + timing.segment1), quanta));
  return timing;
}

BaudrateSelection select_baudrate(Controller controller, std::uint8_t us_baudrate,
                                  BitTimingRegisters given) noexcept {
  if (us_baudrate == 0) return {given, 0};
  constexpr std::uint8_t kFallback = 3;  // 125 kbit/s
  BaudrateSelection selection{{}, kBaudrateInputError};
  for (const BitTimingPreset& preset : kBitTimingPresets) {
    if (preset.controller != controller) continue;
    if (preset.us_baudrate == us_baudrate) return {preset.registers, 0};
    if (preset.us_baudrate == kFallback) selection.registers = preset.registers;
  }
  return selection;
}

}  // namespace can
