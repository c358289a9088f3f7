#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

/// Diagnostic messages of SAE J1939-73: DM1 (active faults) and DM2 (previous ones).
namespace j1939 {

/// State of a lamp: two bits.
enum class Lamp : std::uint8_t { off, on, reserved, not_available };

/// What a lamp that is on does: two bits.
enum class LampFlash : std::uint8_t { slow, fast, reserved, steady };

/// The four lamps of a diagnostic message, in the order of its bits from the highest.
struct Lamps {
  Lamp malfunction = Lamp::off;
  Lamp red_stop = Lamp::off;
  Lamp amber_warning = Lamp::off;
  Lamp protect = Lamp::off;
  std::array<LampFlash, 4> flash = {};  ///< of each, in the same order

  friend bool operator==(const Lamps&, const Lamps&) = default;
};

/// A diagnostic trouble code.
struct TroubleCode {
  std::uint32_t spn = 0;         ///< suspect parameter number, 0..0x7FFFF
  std::uint8_t fmi = 0;          ///< failure mode identifier, 0..31
  std::uint8_t occurrences = 0;  ///< 0..126; 127: not available
  bool old_conversion = false;   ///< the number is put together in one of the forms before 1996

  friend bool operator==(const TroubleCode&, const TroubleCode&) = default;
};

/// Most codes of one message.
inline constexpr std::size_t kMostTroubleCodes = 445;

/// The lamps in the first two bytes; nothing: it is shorter. Realtime safe; any thread.
std::optional<Lamps> lamps_of(std::span<const std::uint8_t> message) noexcept;

/// How many codes a message of so many bytes holds, padding and the entry for "none" left out.
std::size_t trouble_codes_in(std::span<const std::uint8_t> message) noexcept;

/// The code at `index`, which lies below `trouble_codes_in`. Realtime safe; any thread.
TroubleCode trouble_code(std::span<const std::uint8_t> message, std::size_t index) noexcept;

}  // namespace j1939
