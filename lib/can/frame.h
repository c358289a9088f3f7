#pragma once

#include <array>
#include <cstdint>

namespace can {

/// Bits of an 11-bit and of a 29-bit identifier.
inline constexpr std::uint32_t kStandardIdentifierMask = 0x7FF;
inline constexpr std::uint32_t kExtendedIdentifierMask = 0x1FFFFFFF;

/// One classic CAN frame: data or remote, with an 11-bit or a 29-bit identifier; or an error frame, as the
/// kernel and its logs write one. Of an identifier that is too large for its kind the lower bits count.
struct Frame {
  std::uint32_t id = 0;   ///< 0..0x7FF; extended 0..0x1FFFFFFF; error frame: its class bits (CAN_ERR_*)
  bool extended = false;  ///< the identifier has 29 bits
  bool remote = false;    ///< asks for data: has a length code, and no data bytes
  bool error = false;     ///< error frame; not with `extended` or `remote`
  std::uint8_t dlc = 0;   ///< number of data bytes, 0..8
  std::array<std::uint8_t, 8> data = {};  ///< bytes beyond `dlc`, and all of a remote frame, are zero

  /// A data frame with an 11-bit identifier.
  constexpr bool is_standard_data() const noexcept { return !extended && !remote && !error; }
  /// The identifier within the bits that its kind has.
  constexpr std::uint32_t identifier() const noexcept {
    return id & (extended || error ? kExtendedIdentifierMask : kStandardIdentifierMask);
  }

  friend bool operator==(const Frame&, const Frame&) = default;
};

}  // namespace can
