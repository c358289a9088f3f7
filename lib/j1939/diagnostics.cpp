#include "j1939/diagnostics.h"

#include <algorithm>

namespace j1939 {
namespace {

constexpr std::size_t kLampBytes = 2;
constexpr std::size_t kCodeBytes = 4;

}  // namespace

std::optional<Lamps> lamps_of(std::span<const std::uint8_t> message) noexcept {
  if (message.size() < kLampBytes) return std::nullopt;
  const auto bits = [&](unsigned byte, unsigned pair) { return message[byte] >> 2 * (3 - pair) & 3; };
  Lamps lamps;
  lamps.malfunction = static_cast<Lamp>(bits(0, 0));
  lamps.red_stop = static_cast<Lamp>(bits(0, 1));
  lamps.amber_warning = static_cast<Lamp>(bits(0, 2));
  lamps.protect = static_cast<Lamp>(bits(0, 3));
  for (unsigned i = 0; i < 4; ++i) lamps.flash[i] = static_cast<LampFlash>(bits(1, i));
  return lamps;
}

std::size_t trouble_codes_in(std::span<const std::uint8_t> message) noexcept {
  if (message.size() < kLampBytes + kCodeBytes) return 0;
  std::size_t count = std::min((message.size() - kLampBytes) / kCodeBytes, kMostTroubleCodes);
  // One entry of zeros alone says that there is none; in one frame the rest is filled with ones.
  const TroubleCode first = trouble_code(message, 0);
  const bool none = (first.spn == 0 && first.fmi == 0) || (first.spn == 0x7FFFF && first.fmi == 31);
  if (count == 1 && none) count = 0;
  return count;
}

TroubleCode trouble_code(std::span<const std::uint8_t> message, std::size_t index) noexcept {
  const std::size_t at = kLampBytes + index * kCodeBytes;
  if (at + kCodeBytes > message.size()) return {};
  const auto bytes = message.subspan(at, kCodeBytes);
  return {
      bytes[0] | std::uint32_t{bytes[1]} << 8 | std::uint32_t{static_cast<std::uint8_t>(bytes[2] >> 5)} << 16,
      static_cast<std::uint8_t>(bytes[2] & 0x1F), static_cast<std::uint8_t>(bytes[3] & 0x7F),
      (bytes[3] & 0x80) != 0};
}

}  // namespace j1939
